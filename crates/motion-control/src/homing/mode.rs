//! What each mode searches for, leg by leg.

/// Which way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    Negative,
    Positive,
}

impl Direction {
    pub(super) fn reversed(self) -> Self {
        match self {
            Self::Negative => Self::Positive,
            Self::Positive => Self::Negative,
        }
    }

    pub(super) fn sign(self) -> i32 {
        match self {
            Self::Negative => -1,
            Self::Positive => 1,
        }
    }

    /// How far `position` lies beyond `origin` this way round; positions wrap.
    pub(super) fn beyond(self, position: i32, origin: i32) -> i64 {
        i64::from(position.wrapping_sub(origin)) * i64::from(self.sign())
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Switch {
    Left,
    Right,
    Home,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// The edge that the search comes to first.
    Edge,
    Middle,
}

/// One switch to find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leg {
    pub(super) switch: Switch,
    pub(super) direction: Direction,
    pub(super) place: Place,
    /// Turn round at the stop switches on the way.
    pub(super) turns_round: bool,
}

impl Leg {
    const LEFT_EDGE: Self =
        Self { switch: Switch::Left, direction: Direction::Negative, place: Place::Edge, turns_round: false };
    const LEFT_MIDDLE: Self = Self { place: Place::Middle, ..Self::LEFT_EDGE };
    const RIGHT_EDGE: Self =
        Self { switch: Switch::Right, direction: Direction::Positive, ..Self::LEFT_EDGE };

    fn home(direction: Direction, turns_round: bool) -> Self {
        Self { switch: Switch::Home, direction, place: Place::Middle, turns_round }
    }
}

/// What to search for: the numbers are those of every TMCL module (TMCM-1311 §9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    pub(super) first: Leg,
    pub(super) second: Option<Leg>,
    pub(super) home_inverted: bool,
}

impl Mode {
    /// 1 to 8, and the same + 128 with the home switch inverted; none for any other number.
    ///
    /// 1: the edge of the left stop switch. 2: the right one's, then the left one's. 3: the right one's edge, then the middle
    /// of the left one. 4: the middle of the left stop switch. 5, 6: the middle of the home switch, in negative or positive
    /// direction, turning round at stop switches. 7, 8: in positive or negative direction, whatever the stop switches say.
    #[must_use]
    pub fn from_number(number: i32) -> Option<Self> {
        let (first, second) = match number & !128 {
            1 => (Leg::LEFT_EDGE, None),
            2 => (Leg::RIGHT_EDGE, Some(Leg::LEFT_EDGE)),
            3 => (Leg::RIGHT_EDGE, Some(Leg::LEFT_MIDDLE)),
            4 => (Leg::LEFT_MIDDLE, None),
            5 => (Leg::home(Direction::Negative, true), None),
            6 => (Leg::home(Direction::Positive, true), None),
            7 => (Leg::home(Direction::Positive, false), None),
            8 => (Leg::home(Direction::Negative, false), None),
            _ => return None,
        };
        Some(Self { first, second, home_inverted: number & 128 != 0 })
    }
}
