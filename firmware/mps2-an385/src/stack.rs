//! How deep the stack has ever been: the start-up code paints it, and what was used has lost its paint.

/// What the start-up code of cortex-m-rt paints with.
const PAINT: u32 = 0xCCCC_CCCC;

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of stack there are.
#[must_use]
pub fn size() -> u32 {
    (top() - bottom()) as u32
}

/// Bytes of stack that were ever used.
#[must_use]
pub fn used() -> u32 {
    let mut place = bottom();
    // SAFETY: between these two addresses of the linker lies the stack, in words.
    while place < top() && unsafe { (place as *const u32).read_volatile() } == PAINT {
        place += 4;
    }
    (top() - place) as u32
}

fn top() -> usize {
    &raw const _stack_start as usize
}

fn bottom() -> usize {
    &raw const _stack_end as usize
}
