//! Instructions and stack of a call, as the emulator counts them.

use core::arch::asm;
use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;

/// The emulated clock moves by 2^10 ns with every instruction (`-icount shift=10`).
const NS_PER_INSTRUCTION: u64 = 1 << 10;
/// SysTick runs at 25 MHz on both machines.
const NS_PER_TICK: u64 = 40;
/// SysTick counts down in 24 bits: 650 000 instructions.
const TICKS: u32 = 0x00ff_ffff;

/// Words of stack that are watched below the caller of a measured function.
const STACK_WORDS: usize = 4096;
const UNTOUCHED: u32 = 0x5ea7_51a1;

/// What a call took.
#[derive(Clone, Copy, Default)]
pub struct Cost {
    /// Instructions executed, those of setting up the arguments and of the return included.
    pub instructions: u32,
    /// Stack below that of the caller.
    pub stack_bytes: u32,
}

impl Cost {
    /// Keeps the larger of each.
    pub fn raise(&mut self, other: Self) {
        self.instructions = self.instructions.max(other.instructions);
        self.stack_bytes = self.stack_bytes.max(other.stack_bytes);
    }
}

/// Counts by SysTick.
pub struct Meter {
    overhead_ticks: u32,
}

impl Meter {
    /// Starts the clock; `None` the second time.
    pub fn start() -> Option<Self> {
        let mut clock = Peripherals::take()?.SYST;
        clock.set_clock_source(SystClkSource::Core);
        clock.set_reload(TICKS);
        clock.clear_current();
        clock.enable_counter();
        let mut meter = Self { overhead_ticks: 0 };
        meter.overhead_ticks = meter.ticks(|| {});
        Some(meter)
    }

    /// Cost of a call. `call` is to be a call of a function pointer from `black_box`, so that it stays between the readings.
    #[inline(always)]
    pub fn cost(&self, call: impl FnOnce()) -> Cost {
        let bottom = paint();
        let ticks = self.ticks(call) - self.overhead_ticks;
        Cost {
            instructions: (u64::from(ticks) * NS_PER_TICK).div_ceil(NS_PER_INSTRUCTION) as u32,
            stack_bytes: used(bottom),
        }
    }

    #[inline(always)]
    fn ticks(&self, call: impl FnOnce()) -> u32 {
        let before = SYST::get_current();
        call();
        before.wrapping_sub(SYST::get_current()) & TICKS
    }
}

/// Fills the free stack; its upper end.
#[inline(always)]
fn paint() -> *mut u32 {
    let bottom: *mut u32;
    // SAFETY: reads a register.
    unsafe { asm!("mov {}, sp", out(reg) bottom) };
    for word in 1..=STACK_WORDS {
        // SAFETY: the stack is 4 MB, nothing is alive below its pointer, and no interrupt is on.
        unsafe { bottom.wrapping_sub(word).write_volatile(UNTOUCHED) };
    }
    black_box(bottom)
}

/// Bytes below `bottom` down to the last that was written to.
#[inline(always)]
fn used(bottom: *mut u32) -> u32 {
    // SAFETY: as in `paint`.
    let touched = |word: &usize| unsafe { bottom.wrapping_sub(*word).read_volatile() } != UNTOUCHED;
    let deepest = (1..=STACK_WORDS).rev().find(touched).unwrap_or(0);
    (deepest * size_of::<u32>()) as u32
}
