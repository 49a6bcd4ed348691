//! Machine code of x86-64 processors back to text.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use cranelift_codegen::{CompiledCode, Final, MachSrcLoc};
use iced_x86::{
    Decoder, DecoderOptions, Formatter, Instruction, IntelFormatter, MemorySize, Mnemonic, OpKind,
    SymbolResolver, SymbolResult,
};

use crate::sir::Site;
use crate::text::{Line, Names, label, site};

/// The lines of a compiled function, with labels where jumps go.
/// `routines` are names of routines by where in the code their addresses will be.
pub(crate) fn lines(
    compiled: &CompiledCode,
    sites: &[Site],
    names: Names,
    routines: HashMap<u64, String>,
) -> Vec<Line> {
    let code = Code { bytes: compiled.code_buffer(), ranges: compiled.buffer.get_srclocs_sorted() };
    let pieces = code.pieces();
    let targets: BTreeSet<u64> = pieces.iter().flat_map(|(_, piece)| piece.targets()).collect();
    let labels: BTreeMap<u64, String> =
        targets.into_iter().zip(0..).map(|(target, n)| (target, format!("L{n}"))).collect();
    let mut formatter = formatter(Resolver { labels: labels.clone(), names, routines });
    let mut lines = Vec::new();
    for (offset, piece) in &pieces {
        lines.extend(labels.get(offset).map(|name| label(format!("{name}:"))));
        let mut text = "    ".to_owned();
        match piece {
            Piece::Instruction(instruction) => {
                formatter.format(instruction, &mut text);
                text.extend(code.operand(instruction).map(|value| format!("    ; {value}")));
            }
            Piece::JumpTable(targets) => {
                text.push_str("table");
                targets.iter().for_each(|target| text.extend([" ", labels[target].as_str()]));
            }
        }
        let range = code.range(*offset);
        let site = range.and_then(|range| site(range.loc, sites));
        lines.push(Line { offset: Some(*offset as u32), text, site });
    }
    lines
}

struct Code<'c> {
    bytes: &'c [u8],
    /// Where each source location begins and ends: all of the code, but for the constants behind it.
    ranges: &'c [MachSrcLoc<Final>],
}

enum Piece {
    Instruction(Instruction),
    /// Where each entry leads.
    JumpTable(Vec<u64>),
}

impl Piece {
    fn targets(&self) -> Vec<u64> {
        match self {
            Piece::Instruction(instruction) if is_jump(instruction) => {
                vec![instruction.near_branch_target()]
            }
            Piece::Instruction(_) => Vec::new(),
            Piece::JumpTable(targets) => targets.clone(),
        }
    }
}

impl Code<'_> {
    fn end(&self) -> u64 {
        self.ranges.iter().map(|range| u64::from(range.end)).max().unwrap_or(0)
    }

    fn range(&self, offset: u64) -> Option<&MachSrcLoc<Final>> {
        let next = self.ranges.partition_point(|range| u64::from(range.start) <= offset);
        self.ranges[..next].last().filter(|range| offset < u64::from(range.end))
    }

    /// Instructions and jump tables by their offset. A table lies behind the jump that reads it; its
    /// address is loaded before that.
    fn pieces(&self) -> Vec<(u64, Piece)> {
        let end = self.end();
        let code = &self.bytes[..end as usize];
        let mut decoder = Decoder::with_ip(64, code, 0, DecoderOptions::NONE);
        let mut tables = BTreeSet::new();
        let mut pieces = Vec::new();
        while decoder.can_decode() {
            let offset = decoder.ip();
            if tables.contains(&offset)
                && let Some(range) = self.range(offset)
            {
                pieces.push((offset, self.jump_table(offset, u64::from(range.end))));
                decoder = Decoder::with_ip(64, &code[range.end as usize..], range.end.into(), 0);
                continue;
            }
            let instruction = decoder.decode();
            if instruction.mnemonic() == Mnemonic::Lea && instruction.is_ip_rel_memory_operand() {
                tables.insert(instruction.ip_rel_memory_address());
            }
            pieces.push((offset, Piece::Instruction(instruction)));
        }
        pieces
    }

    /// The table between these offsets: distances from its start.
    fn jump_table(&self, start: u64, end: u64) -> Piece {
        let (entries, _) = self.bytes[start as usize..end as usize].as_chunks::<4>();
        let target =
            |entry: &[u8; 4]| start.wrapping_add_signed(i64::from(i32::from_le_bytes(*entry)));
        Piece::JumpTable(entries.iter().map(target).collect())
    }

    /// The constant that an instruction reads, if it is a real.
    fn operand(&self, instruction: &Instruction) -> Option<String> {
        if !instruction.is_ip_rel_memory_operand()
            || instruction.memory_size() != MemorySize::Float64
        {
            return None;
        }
        let start = usize::try_from(instruction.ip_rel_memory_address()).ok()?;
        let bytes = self.bytes.get(start..)?.first_chunk()?;
        Some(format!("{:?}", f64::from_le_bytes(*bytes)))
    }
}

fn is_jump(instruction: &Instruction) -> bool {
    instruction.op0_kind() == OpKind::NearBranch64
}

/// Names for the targets of jumps and for addresses.
struct Resolver {
    labels: BTreeMap<u64, String>,
    names: Names,
    routines: HashMap<u64, String>,
}

impl SymbolResolver for Resolver {
    fn symbol(
        &mut self,
        instruction: &Instruction,
        operand: u32,
        _instruction_operand: Option<u32>,
        address: u64,
        _address_size: u32,
    ) -> Option<SymbolResult<'_>> {
        let name = if is_jump(instruction) {
            self.labels.get(&address).map(String::as_str)
        } else if operand == 1 && instruction.op1_kind() == OpKind::Immediate64 {
            // The immediate operand is the end of the instruction.
            let routine = self.routines.get(&(instruction.next_ip() - 8));
            routine.map(String::as_str).or_else(|| self.names.get(address))
        } else {
            None
        };
        Some(SymbolResult::with_str(address, name?))
    }
}

fn formatter(resolver: Resolver) -> IntelFormatter {
    let mut formatter = IntelFormatter::with_options(Some(Box::new(resolver)), None);
    let options = formatter.options_mut();
    options.set_space_after_operand_separator(true);
    options.set_hex_prefix("0x");
    options.set_hex_suffix("");
    options.set_uppercase_hex(false);
    options.set_rip_relative_addresses(true);
    options.set_show_branch_size(false);
    formatter
}
