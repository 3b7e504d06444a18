//! Global parameters: the module's settings (bank 0), user variables (bank 2) and interrupt settings (bank 3)
//! (TMCM-1311 §10, TMCM-1640 §6).

use tmcl_tables::{GlobalParameter, ModuleSpec};

use crate::TICKS_PER_MS;
use crate::application::ProgramStatus;
use crate::values::Values;

/// The bank of user variables.
pub(crate) const VARIABLE_BANK: u8 = 2;

/// What locks the EEPROM when written to parameter 73, and what unlocks it.
const LOCK: i32 = 1234;
const UNLOCK: i32 = 4321;

/// What parameter 64 reads while the EEPROM holds settings of this firmware.
pub(crate) const MAGIC: i32 = 228;

/// What a module without global parameters works with: its addresses and the host's (decision: factory settings).
const FIXED: [(GlobalParameter, i32); 2] =
    [(GlobalParameter::SerialAddress, 1), (GlobalParameter::HostAddress, 2)];

/// Banks 0, 2 and 3.
#[derive(Clone, Debug)]
pub(crate) struct Globals {
    values: Values<{ GlobalParameter::COUNT }>,
    variables: Values<256>,
    /// What parameter 132 counted when `ticks` was 0.
    tick_timer_offset: u32,
    random: u32,
}

impl Globals {
    /// Factory settings.
    pub(crate) fn new(spec: &ModuleSpec) -> Self {
        let (values, variables) = (Values::zero(), Values::zero());
        let mut globals = Self { values, variables, tick_timer_offset: 0, random: 0 };
        globals.reset(spec);
        globals
    }

    /// Factory settings again.
    pub(crate) fn reset(&mut self, spec: &ModuleSpec) {
        let Self { values, variables, tick_timer_offset, random } = self;
        values.clear();
        variables.clear();
        (*tick_timer_offset, *random) = (0, 0x2545_F491);
        for (parameter, factory) in FIXED {
            values.set(parameter.index(), factory);
        }
        for parameter in GlobalParameter::ALL {
            let (bank, number) = parameter.address();
            if let Some(entry) = spec.global_parameter(bank, number) {
                values.set(parameter.index(), entry.parameter.default_bits());
            }
        }
    }

    /// A setting as a plain value.
    pub(crate) fn setting(&self, parameter: GlobalParameter) -> i32 {
        self.values.get(parameter.index())
    }

    /// A setting whose range is 0 to 255.
    pub(crate) fn byte(&self, parameter: GlobalParameter) -> u8 {
        u8::try_from(self.setting(parameter)).unwrap_or(0)
    }

    /// Whether the configuration is locked.
    pub(crate) fn is_locked(&self) -> bool {
        self.setting(GlobalParameter::EepromLock) != 0
    }

    /// What GGP reads at `ticks`. Reading the random number draws the next one.
    pub(crate) fn read(&mut self, parameter: GlobalParameter, ticks: u64, program: ProgramStatus) -> i32 {
        match parameter {
            GlobalParameter::RandomNumber => self.draw(ticks),
            _ => self.peek(parameter, ticks, program),
        }
    }

    /// What GGP would read at `ticks`, but that no random number is drawn: it is the one that was drawn last.
    pub(crate) fn peek(&self, parameter: GlobalParameter, ticks: u64, program: ProgramStatus) -> i32 {
        use GlobalParameter as G;
        match parameter {
            G::TickTimer => milliseconds(ticks).wrapping_add(self.tick_timer_offset).cast_signed(),
            G::RandomNumber => random_value(self.random),
            G::ApplicationStatus => i32::from(program.mode),
            G::DownloadMode => i32::from(program.downloading),
            G::ProgramCounter => i32::from(program.address),
            G::EepromMagic
            | G::BaudRate
            | G::SerialAddress
            | G::AsciiMode
            | G::SerialHeartbeat
            | G::CanBitRate
            | G::CanReplyId
            | G::CanId
            | G::EepromLock
            | G::TelegramPause
            | G::HostAddress
            | G::AutoStart
            | G::EndSwitchPolarity
            | G::CodeProtection
            | G::CanSecondaryId
            | G::CoordinateStorage
            | G::DoNotRestoreVariables
            | G::SerialSecondaryAddress
            | G::InterfaceSelection
            | G::SuppressReply
            | G::Timer0Period
            | G::Timer1Period
            | G::Timer2Period
            | G::StopLeftEdge
            | G::StopRightEdge
            | G::Input0Edge
            | G::Input1Edge
            | G::Input2Edge
            | G::Input3Edge
            | G::Input4Edge
            | G::Input5Edge
            | G::Input6Edge
            | G::Input7Edge => self.setting(parameter),
        }
    }

    /// What SGP writes; range and access were checked before.
    pub(crate) fn write(&mut self, parameter: GlobalParameter, value: i32, ticks: u64) {
        match (parameter, value) {
            (GlobalParameter::TickTimer, _) => {
                self.tick_timer_offset = value.cast_unsigned().wrapping_sub(milliseconds(ticks));
            }
            (GlobalParameter::EepromLock, LOCK) => self.values.set(parameter.index(), 1),
            (GlobalParameter::EepromLock, UNLOCK) => self.values.set(parameter.index(), 0),
            _ => self.values.set(parameter.index(), value),
        }
    }

    /// Puts back what was stored.
    pub(crate) fn restore(&mut self, parameter: GlobalParameter, value: i32) {
        self.values.set(parameter.index(), value);
    }

    pub(crate) fn variable(&self, number: u8) -> i32 {
        self.variables.get(usize::from(number))
    }

    pub(crate) fn set_variable(&mut self, number: u8, value: i32) {
        self.variables.set(usize::from(number), value);
    }

    /// Marsaglia's 32-bit xorshift, stirred with the time of asking: no two runs differ unless their inputs do.
    fn draw(&mut self, ticks: u64) -> i32 {
        let mut state = self.random ^ milliseconds(ticks).rotate_left(16);
        if state == 0 {
            state = 1;
        }
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        self.random = state;
        random_value(state)
    }
}

/// What parameter 133 reads in this state of the generator: 31 bits.
fn random_value(state: u32) -> i32 {
    (state >> 1).cast_signed()
}

/// The counter of parameter 132 wraps at 32 bits.
fn milliseconds(ticks: u64) -> u32 {
    u32::try_from((ticks / TICKS_PER_MS) & u64::from(u32::MAX)).unwrap_or(0)
}
