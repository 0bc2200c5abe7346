//! The floating-point environment of a call: ours inside, the importer's before and after.
//!
//! Compiled code takes for granted that nothing traps and that results are rounded to nearest, and the same bits everywhere need it. An importer may have
//! it otherwise, and its flags are its own.

/// The importer's environment, restored when dropped.
pub(crate) struct FloatEnvironment(registers::Saved);

impl FloatEnvironment {
    /// Saves the importer's environment and enters ours.
    #[inline]
    pub(crate) fn enter() -> Self {
        Self(registers::enter())
    }
}

impl Drop for FloatEnvironment {
    #[inline]
    fn drop(&mut self) {
        registers::restore(self.0);
    }
}

#[cfg(target_arch = "x86_64")]
mod registers {
    use core::arch::asm;

    /// MXCSR.
    pub type Saved = u32;

    /// All exceptions masked, to nearest, no flushing of small numbers, no flag raised (Intel SDM, volume 1, 10.2.3).
    const DEFAULT: u32 = 0x1F80;

    #[inline]
    pub fn enter() -> Saved {
        let mut saved: Saved = 0;
        // SAFETY: stores four bytes there.
        unsafe { asm!("stmxcsr [{}]", in(reg) &mut saved, options(nostack, preserves_flags)) };
        set(DEFAULT);
        saved
    }

    #[inline]
    pub fn restore(saved: Saved) {
        set(saved);
    }

    #[inline]
    fn set(value: u32) {
        // SAFETY: no reserved bit is set: it is the default, or what was there before.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &value, options(nostack, preserves_flags, readonly)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod registers {
    use core::arch::asm;

    /// FPCR and FPSR.
    pub type Saved = [u64; 2];

    #[inline]
    pub fn enter() -> Saved {
        let (control, status): (u64, u64);
        // SAFETY: reads two registers.
        unsafe { asm!("mrs {}, fpcr", "mrs {}, fpsr", out(reg) control, out(reg) status, options(nomem, nostack)) };
        restore([0, 0]);
        [control, status]
    }

    #[inline]
    pub fn restore([control, status]: Saved) {
        // SAFETY: zero is the default: nothing traps, to nearest, no flag raised (Arm ARM, D24.2); otherwise it is what was there before.
        unsafe { asm!("msr fpcr, {}", "msr fpsr, {}", in(reg) control, in(reg) status, options(nomem, nostack)) };
    }
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod registers {
    pub type Saved = ();

    pub fn enter() -> Saved {}

    pub fn restore((): Saved) {}
}
