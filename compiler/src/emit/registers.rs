//! Registers of one function: which are free, and how often each is referred to.

/// Above this many live registers, new bindings go to spill slots and the pending operands to the
/// operand stack, so that there is always room for temporaries.
pub(super) const CROWDED: usize = 192;

/// Reference counts of the 256 registers.
#[derive(Clone, Debug)]
pub(super) struct Registers {
    /// A program may have more words than sixteen bits count.
    references: [u32; 256],
    live: usize,
}

impl Registers {
    pub(super) fn new() -> Self {
        Registers { references: [0; 256], live: 0 }
    }

    /// The lowest free register, with one reference.
    pub(super) fn allocate(&mut self) -> Option<u8> {
        let free = self.references.iter().position(|&count| count == 0)? as u8;
        self.retain(free);
        Some(free)
    }

    pub(super) fn retain(&mut self, register: u8) {
        let count = &mut self.references[register as usize];
        self.live += usize::from(*count == 0);
        *count += 1;
    }

    pub(super) fn release(&mut self, register: u8) {
        let count = &mut self.references[register as usize];
        *count -= 1;
        self.live -= usize::from(*count == 0);
    }

    pub(super) fn is_free(&self, register: u8) -> bool {
        self.references[register as usize] == 0
    }

    /// Whether nothing but the holder of one reference knows of it.
    pub(super) fn is_temporary(&self, register: u8) -> bool {
        self.references[register as usize] == 1
    }

    pub(super) fn is_crowded(&self) -> bool {
        self.live > CROWDED
    }
}
