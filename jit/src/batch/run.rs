//! Steps at all points.

use compiler::degrees;
use compiler::op::Operator;
use compiler::scalar::{self, Fault};
use glam::DVec3;
use renderer::surface::{SurfacePoint, SurfaceSample};

use super::{ARGUMENTS, Action, Batch, Operand, Step, WIDTH};
use crate::sir::Table;

/// A register: 64 bits for each point.
type Register = [u64; WIDTH];

/// Memory for batches, kept from one to the next.
#[derive(Debug)]
pub(crate) struct Lanes {
    registers: Vec<Register>,
    /// Where there is no answer.
    left: Box<Register>,
}

impl Default for Lanes {
    fn default() -> Self {
        Lanes { registers: Vec::new(), left: Box::new([0; WIDTH]) }
    }
}

/// Points are a multiple of this in number, so that loops of vector instructions have no rest.
const STRIDE: usize = 8;

impl Batch {
    /// Appends what the shader of a closure with these uniforms answers at each point, or none where
    /// the interpreter must have a look.
    ///
    /// # Panics
    /// If there are more than [`WIDTH`] points.
    pub(crate) fn run(
        &self,
        tables: &[Table],
        uniforms: &[u64],
        points: &[SurfacePoint],
        lanes: &mut Lanes,
        samples: &mut Vec<Option<SurfaceSample>>,
    ) {
        let n = points.len().next_multiple_of(STRIDE);
        if lanes.registers.len() < self.n_registers {
            lanes.registers.resize(self.n_registers, [0; WIDTH]);
        }
        let Some(last) = points.last() else { return };
        let [face, u, v] = distinct(&mut lanes.registers, ARGUMENTS.map(|r| r as usize));
        for (index, at) in points.iter().enumerate() {
            (face[index], u[index], v[index]) =
                (u64::from(at.face), at.u.to_bits(), at.v.to_bits());
        }
        for (register, bits) in
            [(face, u64::from(last.face)), (u, last.u.to_bits()), (v, last.v.to_bits())]
        {
            register[points.len()..].fill(bits);
        }
        *lanes.left = [0; WIDTH];
        let mut running = Running { n, tables, uniforms, lanes };
        let mut at = 0;
        while let Some(step) = self.steps.get(at) {
            at += 1 + running.step(step);
        }
        let Lanes { registers, left } = lanes;
        let [red, green, blue, kd, ks, phong_exp] = self.results.map(|r| &registers[r as usize]);
        samples.extend((0..points.len().min(WIDTH)).map(|index| {
            let number = |register: &Register| f64::from_bits(register[index]);
            let color = DVec3::new(number(red), number(green), number(blue));
            let (kd, ks, phong_exp) = (number(kd), number(ks), number(phong_exp));
            (left[index] == 0).then_some(SurfaceSample { color, kd, ks, phong_exp })
        }));
    }
}

/// A batch that runs on the first `n` points, a multiple of [`STRIDE`].
struct Running<'r> {
    n: usize,
    tables: &'r [Table],
    uniforms: &'r [u64],
    lanes: &'r mut Lanes,
}

/// Where an operand is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Register(usize),
    Same(u64),
}

impl Running<'_> {
    /// Returns how many steps are passed over.
    fn step(&mut self, step: &Step) -> usize {
        match step.action {
            Action::Scalar(op) => self.scalar(op, step),
            Action::Copy => self.each_one(step, |a| a),
            Action::Blend => self.blend(step),
            Action::And => self.each(step, |a, b| a & b),
            Action::AndNot => self.each(step, |a, b| a & !b),
            Action::Or => self.each(step, |a, b| a | b),
            Action::IntOfBool => self.each_one(step, |a| a & 1),
            // Unsigned, negative indices are the largest.
            Action::Checked(length) => self.try_each(step, |a, _| (a, a < u64::from(length))),
            Action::Offset(stride) => {
                self.each(step, |a, b| a.wrapping_mul(u64::from(stride)).wrapping_add(b));
            }
            Action::Entry { table, column } => {
                let tables = self.tables;
                let column = tables[table as usize].entries().get(column as usize..).unwrap_or(&[]);
                // Where the mask does not hold, the index may be any.
                let entry = |start: u64| column.get(usize::try_from(start).unwrap_or(usize::MAX));
                self.each_one(step, |a| entry(a).copied().unwrap_or_default());
            }
            Action::Leave => self.leave(step.mask),
            Action::Skip(n_steps) => {
                let holds = self.all(step.mask)[..self.n].iter().fold(0, |any, mask| any | mask);
                return if holds != 0 { 0 } else { n_steps as usize };
            }
        }
        0
    }

    fn scalar(&mut self, op: Operator, step: &Step) {
        match op {
            Operator::AddF => self.reals(step, scalar::add_f),
            Operator::SubF => self.reals(step, scalar::sub_f),
            Operator::MulF => self.reals(step, scalar::mul_f),
            Operator::DivF => self.reals(step, scalar::div_f),
            Operator::NegF => self.real(step, scalar::neg_f),
            Operator::Frac => self.real(step, scalar::frac),
            Operator::ClampF => self.real(step, scalar::clamp_f),
            Operator::Sin if self.are_direct(step.a) => self.direct(step, degrees::sin_direct),
            Operator::Cos if self.are_direct(step.a) => self.direct(step, degrees::cos_direct),
            Operator::Sin => self.real(step, scalar::sin),
            Operator::Cos => self.real(step, scalar::cos),
            Operator::Asin => self.real(step, scalar::asin),
            Operator::Acos => self.real(step, scalar::acos),
            Operator::Sqrt => self.try_each(step, |a, _| {
                let root = scalar::sqrt(f64::from_bits(a));
                (root.map_or(0, f64::to_bits), root.is_ok())
            }),
            Operator::Floor => self.try_each(step, |a, _| {
                let below = scalar::floor(f64::from_bits(a));
                (below.unwrap_or(0) as u64, below.is_ok())
            }),
            Operator::RealOf => {
                self.each_one(step, |a| scalar::real(a as i64).map_or(0, f64::to_bits))
            }
            Operator::EqF => {
                self.each(step, |a, b| mask(scalar::eq_f(f64::from_bits(a), f64::from_bits(b))))
            }
            Operator::LessF => {
                self.each(step, |a, b| mask(scalar::less_f(f64::from_bits(a), f64::from_bits(b))))
            }
            Operator::EqI => self.each(step, |a, b| mask(scalar::eq_i(a as i64, b as i64))),
            Operator::LessI => self.each(step, |a, b| mask(scalar::less_i(a as i64, b as i64))),
            Operator::AddI => self.ints(step, scalar::add_i),
            Operator::SubI => self.ints(step, scalar::sub_i),
            Operator::MulI => self.ints(step, scalar::mul_i),
            Operator::DivI => self.ints(step, scalar::div_i),
            Operator::ModI => self.ints(step, scalar::mod_i),
            Operator::NegI => self.ints(step, |a, _| scalar::neg_i(a)),
            _ => unreachable!("the specializer performs {op:?} itself"),
        }
    }

    /// Of an operator on reals that always has a result.
    #[inline(always)]
    fn reals(&mut self, step: &Step, f: impl Fn(f64, f64) -> Result<f64, Fault>) {
        self.each(step, |a, b| f(f64::from_bits(a), f64::from_bits(b)).map_or(0, f64::to_bits));
    }

    #[inline(always)]
    fn real(&mut self, step: &Step, f: impl Fn(f64) -> Result<f64, Fault>) {
        self.each_one(step, |a| f(f64::from_bits(a)).map_or(0, f64::to_bits));
    }

    #[inline(always)]
    fn ints(&mut self, step: &Step, f: impl Fn(i64, i64) -> Result<i64, Fault>) {
        self.try_each(step, |a, b| {
            let result = f(a as i64, b as i64);
            (result.unwrap_or(0) as u64, result.is_ok())
        });
    }

    /// Whether an operand is a register of angles that need no more than the direct functions.
    fn are_direct(&self, angles: Operand) -> bool {
        let Operand::Register(register) = angles else { return false };
        let angles = &self.lanes.registers[register as usize][..self.n];
        angles.iter().fold(true, |all, bits| all & degrees::is_direct(f64::from_bits(*bits)))
    }

    /// Such a function. It is too long to be part of the loops of [`Running::each`].
    #[inline(always)]
    fn direct(&mut self, step: &Step, f: impl Fn(f64) -> f64) {
        let Operand::Register(angles) = step.a else { unreachable!("direct angles are registers") };
        let n = self.n;
        let [to, angles] = distinct(&mut self.lanes.registers, [step.to as usize, angles as usize]);
        set(&mut to[..n], &angles[..n], |bits| f(f64::from_bits(bits)).to_bits());
    }

    fn place(&self, operand: Operand) -> Place {
        match operand {
            Operand::Register(register) => Place::Register(register as usize),
            Operand::Same(bits) => Place::Same(bits),
            Operand::Uniform(index) => Place::Same(self.uniforms[index as usize]),
        }
    }

    /// Sets the result from the operands at each point.
    #[inline(always)]
    fn each(&mut self, step: &Step, f: impl Fn(u64, u64) -> u64) {
        let (to, n) = (step.to as usize, self.n);
        let (a, b) = (self.place(step.a), self.place(step.b));
        let registers = &mut self.lanes.registers;
        match (a, b) {
            (Place::Same(a), Place::Same(b)) => registers[to][..n].fill(f(a, b)),
            (Place::Register(a), Place::Same(b)) => {
                let [to, a] = distinct(registers, [to, a]);
                set(&mut to[..n], &a[..n], |a| f(a, b));
            }
            (Place::Same(a), Place::Register(b)) => {
                let [to, b] = distinct(registers, [to, b]);
                set(&mut to[..n], &b[..n], |b| f(a, b));
            }
            (Place::Register(a), Place::Register(b)) if a == b => {
                let [to, a] = distinct(registers, [to, a]);
                set(&mut to[..n], &a[..n], |a| f(a, a));
            }
            (Place::Register(a), Place::Register(b)) => {
                let [to, a, b] = distinct(registers, [to, a, b]);
                let (to, a, b) = (&mut to[..n], &a[..n], &b[..n]);
                for index in 0..n {
                    to[index] = f(a[index], b[index]);
                }
            }
        }
    }

    /// The same for one operand.
    #[inline(always)]
    fn each_one(&mut self, step: &Step, f: impl Fn(u64) -> u64) {
        let (to, n) = (step.to as usize, self.n);
        match self.place(step.a) {
            Place::Same(a) => self.lanes.registers[to][..n].fill(f(a)),
            Place::Register(a) => {
                let [to, a] = distinct(&mut self.lanes.registers, [to, a]);
                set(&mut to[..n], &a[..n], f);
            }
        }
    }

    /// The same; where the mask holds and the flag does not, there is no answer.
    #[inline(always)]
    fn try_each(&mut self, step: &Step, f: impl Fn(u64, u64) -> (u64, bool)) {
        let [a, b, mask] = [step.a, step.b, step.mask].map(|operand| self.all(operand));
        let Lanes { registers, left } = &mut *self.lanes;
        let to = &mut registers[step.to as usize];
        for index in 0..self.n {
            let (bits, has) = f(a[index], b[index]);
            to[index] = bits;
            left[index] |= if has { 0 } else { mask[index] };
        }
    }

    fn blend(&mut self, step: &Step) {
        let [a, mask] = [step.a, step.mask].map(|operand| self.all(operand));
        let to = &mut self.lanes.registers[step.to as usize];
        for index in 0..self.n {
            to[index] = a[index] & mask[index] | to[index] & !mask[index];
        }
    }

    fn leave(&mut self, mask: Operand) {
        let mask = self.all(mask);
        for (left, mask) in self.lanes.left.iter_mut().zip(mask) {
            *left |= mask;
        }
    }

    /// A copy of an operand.
    fn all(&self, operand: Operand) -> Register {
        match self.place(operand) {
            Place::Register(register) => self.lanes.registers[register],
            Place::Same(bits) => [bits; WIDTH],
        }
    }
}

#[inline(always)]
fn set(to: &mut [u64], from: &[u64], f: impl Fn(u64) -> u64) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = f(*from);
    }
}

/// These registers, which are different ones by construction.
#[inline(always)]
fn distinct<const N: usize>(registers: &mut [Register], numbers: [usize; N]) -> [&mut Register; N] {
    registers.get_disjoint_mut(numbers).expect("the registers of a step are different ones")
}

fn mask(is: Result<bool, Fault>) -> u64 {
    if is == Ok(true) { !0 } else { 0 }
}
