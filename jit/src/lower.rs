//! SSA to Cranelift's intermediate representation.
//!
//! Arithmetic becomes the same IEEE operations that `compiler::scalar` performs, in the same order
//! and never contracted. Where that has no result (overflow, a root of a negative number, ...) the
//! code branches to one block, which returns that it has left.
//!
//! A routine takes how many further calls may be active, the fuel, the signature so far if there is one,
//! and its parameters; it returns the fuel that is left, a negative number if the interpreter must have
//! a look, the signature, and its results.

use cranelift_codegen::ir::condcodes::{FloatCC, IntCC};
use cranelift_codegen::ir::{
    self, AbiParam, BlockArg, InstBuilder, JumpTableData, MemFlagsData, Signature, SourceLoc, types,
};
use cranelift_codegen::isa::{CallConv, TargetFrontendConfig};
use cranelift_frontend::{FunctionBuilder, FunctionBuilderContext, Variable};
use renderer::signature::Signature as Decisions;

use crate::abi::{DONE, LEFT};
use crate::sir::{
    Block, Body, FACE, Inst, N_ARGUMENTS, Relation, Routine, Shader, Site, Term, Type, U, V, Val,
    Version,
};

mod constants;
mod operators;
mod subscripts;

/// The signature of [`SurfaceFn`](crate::abi::SurfaceFn), or of
/// [`BoundedFn`](crate::abi::BoundedFn) or [`SignedFn`](crate::abi::SignedFn) if the shader is of that
/// version.
pub(crate) fn signature(shader: &Shader, call_conv: CallConv, pointer: ir::Type) -> Signature {
    let mut signature = Signature::new(call_conv);
    let radii = shader.radii().map(|_| types::F64);
    let point = [pointer, types::I64, types::F64, types::F64];
    let params = point.into_iter().chain(radii).chain([pointer]);
    signature.params.extend(params.map(AbiParam::new));
    let returned = if shader.version == Version::Plain { types::F64 } else { types::I32 };
    signature.returns.push(AbiParam::new(returned));
    signature
}

/// The signature of a routine. The convention is the one that returns values in most
/// registers.
pub(crate) fn routine_signature(routine: &Routine, version: Version) -> Signature {
    let body = &routine.body;
    let mut signature = Signature::new(CallConv::Tail);
    let params = body.types[..body.n_params].iter().map(|ty| clif_type(*ty));
    let decisions = (version == Version::Signed).then_some(types::I64);
    let first = [types::I64, types::I64].into_iter().chain(decisions);
    signature.params.extend(first.chain(params).map(AbiParam::new));
    let results = routine.results.iter().map(|ty| clif_type(*ty));
    let first = [types::I64].into_iter().chain(decisions);
    signature.returns.extend(first.chain(results).map(AbiParam::new));
    signature
}

/// What a body of code refers to, and is called by.
pub(crate) struct Surroundings<'s> {
    pub(crate) shader: &'s Shader,
    /// Address of the tables, one after the other.
    pub(crate) tables: *const u64,
    /// The routines, as the function that is filled knows them.
    pub(crate) routines: Vec<ir::FuncRef>,
    /// How many calls of routines may be active at once.
    pub(crate) max_calls: i64,
    pub(crate) config: TargetFrontendConfig,
}

/// Fills `function`, whose signature is set, with the main body of a shader, or with that of the
/// routine of a number. The source locations of its instructions are indices into what is returned;
/// those that serve the whole have none.
pub(crate) fn lower(
    around: &Surroundings<'_>,
    routine: Option<usize>,
    function: &mut ir::Function,
    context: &mut FunctionBuilderContext,
) -> Vec<Site> {
    let shader = around.shader;
    let routine = routine.map(|number| &shader.routines[number]);
    let body = routine.map_or(&shader.main, |routine| &routine.body);
    let mut builder = FunctionBuilder::new(function, context);
    let blocks: Vec<ir::Block> = body.blocks.iter().map(|_| builder.create_block()).collect();
    let entry = builder.create_block();
    let leave = builder.create_block();
    builder.set_cold_block(leave);
    let mut lowering = Lowering {
        around,
        body,
        routine,
        live: body.live(),
        are_subscripts: subscripts::subscripts(body),
        builder,
        values: vec![None; body.types.len()],
        blocks,
        leave,
        point: None,
        fuel: None,
        decisions: None,
        max_calls: None,
        out: None,
        pointer: around.config.pointer_type(),
        call_conv: around.config.default_call_conv,
        sites: Vec::new(),
    };
    lowering.entry(entry);
    for index in 0..body.blocks.len() {
        lowering.block(Block(index as u32));
    }
    lowering.leave();
    let Lowering { mut builder, sites, .. } = lowering;
    builder.seal_all_blocks();
    builder.finalize(around.config);
    sites
}

struct Lowering<'s, 'f> {
    around: &'s Surroundings<'s>,
    body: &'s Body,
    /// The routine that the body is of; none if it is the shader's.
    routine: Option<&'s Routine>,
    live: Vec<bool>,
    /// Which values are whole parts of reals, for nothing but subscripts: those are left as reals.
    are_subscripts: Vec<bool>,
    builder: FunctionBuilder<'f>,
    values: Vec<Option<ir::Value>>,
    blocks: Vec<ir::Block>,
    leave: ir::Block,
    /// The last two numbers of the point of a table that was read last in this block: table, start, numbers.
    point: Option<(u32, Val, ir::Value)>,
    /// What is left of the fuel, if there are loops or calls.
    fuel: Option<Variable>,
    /// The signature of the decisions so far, if the shader is signed.
    decisions: Option<Variable>,
    /// How many further calls of routines may be active, if there are calls.
    max_calls: Option<ir::Value>,
    out: Option<ir::Value>,
    pointer: ir::Type,
    call_conv: CallConv,
    /// The source locations given so far.
    sites: Vec<Site>,
}

fn clif_type(ty: Type) -> ir::Type {
    match ty {
        Type::Real => types::F64,
        Type::Int => types::I64,
        Type::Bool => types::I8,
    }
}

impl Lowering<'_, '_> {
    fn is_live(&self, val: Val) -> bool {
        self.live[val.0 as usize]
    }

    fn value(&self, val: Val) -> ir::Value {
        self.values[val.0 as usize].expect("definitions come before uses")
    }

    /// What follows comes from here.
    fn at(&mut self, site: Site) {
        if self.sites.last() != Some(&site) {
            self.sites.push(site);
        }
        self.builder.set_srcloc(SourceLoc::new(self.sites.len() as u32 - 1));
    }

    /// Arguments, uniforms, and the blocks' parameters.
    fn entry(&mut self, entry: ir::Block) {
        self.builder.append_block_params_for_function_params(entry);
        self.builder.switch_to_block(entry);
        match self.routine {
            None => self.enter_shader(entry),
            Some(_) => self.enter_routine(entry),
        }
        for (index, block) in self.body.blocks.iter().enumerate() {
            for &param in block.params.iter().filter(|param| self.live[param.0 as usize]) {
                let ty = clif_type(self.body.type_of(param));
                let value = self.builder.append_block_param(self.blocks[index], ty);
                self.values[param.0 as usize] = Some(value);
            }
        }
        self.builder.ins().jump(self.blocks[0], &[]);
    }

    fn enter_shader(&mut self, entry: ir::Block) {
        let [environment, face, u, v, radii @ .., out] = self.builder.block_params(entry) else {
            unreachable!("the signature has these parameters")
        };
        let (environment, face, u, v, out) = (*environment, *face, *u, *v, *out);
        for (val, &value) in self.around.shader.radii().zip(radii) {
            self.values[val.0 as usize] = Some(value);
        }
        for (val, value) in [(FACE, face), (U, u), (V, v)] {
            self.values[val.0 as usize] = Some(value);
        }
        self.out = Some(out);
        if self.around.shader.version == Version::Signed {
            let none = self.builder.ins().iconst(types::I64, Decisions::NONE.0 as i64);
            self.declare_decisions(none);
        }
        let flags = MemFlagsData::trusted().with_readonly();
        for index in 0..self.around.shader.n_uniforms {
            let val = Val(N_ARGUMENTS + index);
            if self.is_live(val) {
                let ty = clif_type(self.body.type_of(val));
                let offset = (1 + index as i32) * 8;
                let value = self.builder.ins().load(ty, flags, environment, offset);
                self.values[val.0 as usize] = Some(value);
            }
        }
        let has_calls = self.body.has_calls();
        if has_calls || self.body.blocks.iter().any(|block| block.is_loop) {
            let fuel = self.builder.ins().load(types::I64, flags, environment, 0);
            self.declare_fuel(fuel);
        }
        if has_calls {
            let max_calls = self.builder.ins().iconst(types::I64, self.around.max_calls);
            self.max_calls = Some(max_calls);
            self.take_fuel();
        }
    }

    fn enter_routine(&mut self, entry: ir::Block) {
        let params = self.builder.block_params(entry).to_vec();
        let (first, params) = params.split_at(params.len() - self.body.n_params);
        let (max_calls, fuel) = (first[0], first[1]);
        for (value, &param) in self.values.iter_mut().zip(params) {
            *value = Some(param);
        }
        if let Some(&decisions) = first.get(2) {
            self.declare_decisions(decisions);
        }
        let rest = self.builder.ins().iadd_imm_s(max_calls, -1);
        let is_out = self.builder.ins().icmp_imm_s(IntCC::SignedLessThan, rest, 0);
        self.leave_if(is_out);
        self.max_calls = Some(rest);
        self.declare_fuel(fuel);
        self.take_fuel();
    }

    fn declare_fuel(&mut self, fuel: ir::Value) {
        let variable = self.builder.declare_var(types::I64);
        self.builder.def_var(variable, fuel);
        self.fuel = Some(variable);
    }

    fn declare_decisions(&mut self, decisions: ir::Value) {
        let variable = self.builder.declare_var(types::I64);
        self.builder.def_var(variable, decisions);
        self.decisions = Some(variable);
    }

    /// The signature of the decisions so far, if it is kept.
    fn decisions(&mut self) -> Option<ir::Value> {
        self.decisions.map(|variable| self.builder.use_var(variable))
    }

    /// The block that is jumped to when the interpreter must have a look.
    fn leave(&mut self) {
        self.builder.switch_to_block(self.leave);
        self.builder.set_srcloc(SourceLoc::default());
        let Some(routine) = self.routine else {
            let left = match self.around.shader.version {
                Version::Plain => self.builder.ins().f64const(f64::NAN),
                _ => self.builder.ins().iconst(types::I32, i64::from(LEFT)),
            };
            self.builder.ins().return_(&[left]);
            return;
        };
        let mut results = vec![self.builder.ins().iconst(types::I64, -1)];
        if self.decisions.is_some() {
            results.push(self.builder.ins().iconst(types::I64, 0));
        }
        results.extend(routine.results.iter().map(|ty| match ty {
            Type::Real => self.builder.ins().f64const(0.0),
            Type::Int => self.builder.ins().iconst(types::I64, 0),
            Type::Bool => self.builder.ins().iconst(types::I8, 0),
        }));
        self.builder.ins().return_(&results);
    }

    fn block(&mut self, block: Block) {
        let body = self.body;
        let data = &body.blocks[block.0 as usize];
        self.builder.switch_to_block(self.blocks[block.0 as usize]);
        self.point = None;
        if data.is_loop {
            self.at(data.site);
            self.take_fuel();
        }
        for (val, inst, site) in &data.insts {
            if self.is_live(*val) {
                self.at(*site);
                let value = if self.are_subscripts[val.0 as usize] {
                    self.whole_part(inst)
                } else {
                    self.inst(inst)
                };
                self.values[val.0 as usize] = Some(value);
            }
        }
        match &data.term {
            Some((term, site)) => {
                self.at(*site);
                self.term(term);
            }
            // Nothing leads here.
            None => {
                self.builder.ins().jump(self.leave, &[]);
            }
        }
    }

    /// Pays for one more round or call with the cost of all the code, which none exceeds.
    fn take_fuel(&mut self) {
        let variable = self.fuel.expect("declared when there are loops or calls");
        let fuel = self.builder.use_var(variable);
        let cost = i64::try_from(self.body.costs.fuel).unwrap_or(i64::MAX);
        let rest = self.builder.ins().iadd_imm_s(fuel, cost.wrapping_neg());
        self.builder.def_var(variable, rest);
        let is_out = self.builder.ins().icmp_imm_s(IntCC::SignedLessThan, rest, 0);
        self.leave_if(is_out);
    }

    fn leave_if(&mut self, condition: ir::Value) {
        let on = self.builder.create_block();
        self.builder.ins().brif(condition, self.leave, &[], on, &[]);
        self.builder.switch_to_block(on);
    }

    fn term(&mut self, term: &Term) {
        match term {
            Term::Jump(target, args) => {
                let body = self.body;
                let params = &body.blocks[target.0 as usize].params;
                let arg = |(param, arg): (&Val, &Val)| {
                    self.is_live(*param)
                        .then(|| BlockArg::Value(self.in_register(self.value(*arg))))
                };
                let args: Vec<BlockArg> = params.iter().zip(args).filter_map(arg).collect();
                self.builder.ins().jump(self.blocks[target.0 as usize], &args);
            }
            Term::Branch(condition, [yes, no]) => {
                let condition = self.value(*condition);
                let (yes, no) = (self.blocks[yes.0 as usize], self.blocks[no.0 as usize]);
                self.builder.ins().brif(condition, yes, &[], no, &[]);
            }
            Term::Switch(tag, targets) => self.switch(*tag, targets),
            Term::Return(vals) => self.return_(vals),
            Term::Call(routine, args, next) => self.call_routine(*routine, args, *next),
            Term::Leave => {
                self.builder.ins().jump(self.leave, &[]);
            }
        }
    }

    fn switch(&mut self, tag: Val, targets: &[Block]) {
        let tag = self.value(tag);
        let tag = self.builder.ins().ireduce(types::I32, tag);
        let pool = &mut self.builder.func.dfg.value_lists;
        let call = |block: &Block, pool: &mut ir::ValueListPool| {
            ir::BlockCall::new(self.blocks[block.0 as usize], [], pool)
        };
        let (last, others) = targets.split_last().expect("a choice has alternatives");
        let others: Vec<_> = others.iter().map(|block| call(block, pool)).collect();
        let table = JumpTableData::new(call(last, pool), &others);
        let table = self.builder.create_jump_table(table);
        self.builder.ins().br_table(tag, table);
    }

    fn return_(&mut self, vals: &[Val]) {
        if self.routine.is_some() {
            let fuel = self.fuel.expect("declared for routines");
            let mut results = vec![self.builder.use_var(fuel)];
            results.extend(self.decisions());
            results.extend(vals.iter().map(|val| self.value(*val)));
            self.builder.ins().return_(&results);
            return;
        }
        let out = self.out.expect("set at the entry");
        if self.around.shader.version == Version::Plain {
            let (red, others) = vals.split_first().expect("there are six results");
            self.store_all(others, out);
            let red = self.in_register(self.value(*red));
            self.builder.ins().return_(&[red]);
            return;
        }
        self.store_all(vals, out);
        if let Some(decisions) = self.decisions() {
            let offset = vals.len() as i32 * 8;
            self.builder.ins().store(MemFlagsData::trusted(), decisions, out, offset);
        }
        let done = self.builder.ins().iconst(types::I32, i64::from(DONE));
        self.builder.ins().return_(&[done]);
    }

    fn call_routine(&mut self, routine: u32, args: &[Val], next: Block) {
        let fuel = self.fuel.expect("declared when there are calls");
        let max_calls = self.max_calls.expect("set when there are calls");
        let mut values = vec![max_calls, self.builder.use_var(fuel)];
        values.extend(self.decisions());
        values.extend(args.iter().map(|val| self.value(*val)));
        let call = self.builder.ins().call(self.around.routines[routine as usize], &values);
        let returned = self.builder.inst_results(call).to_vec();
        let (&rest, mut results) = returned.split_first().expect("the fuel is returned first");
        self.builder.def_var(fuel, rest);
        if let (Some(variable), Some((&decisions, others))) =
            (self.decisions, results.split_first())
        {
            self.builder.def_var(variable, decisions);
            results = others;
        }
        let has_left = self.builder.ins().icmp_imm_s(IntCC::SignedLessThan, rest, 0);
        self.leave_if(has_left);
        let params = &self.body.blocks[next.0 as usize].params;
        let args: Vec<BlockArg> = params
            .iter()
            .zip(results)
            .filter(|(param, _)| self.is_live(**param))
            .map(|(_, result)| BlockArg::Value(*result))
            .collect();
        self.builder.ins().jump(self.blocks[next.0 as usize], &args);
    }

    fn inst(&mut self, inst: &Inst) -> ir::Value {
        match *inst {
            Inst::Real(value) => self.builder.ins().f64const(value),
            Inst::Int(value) => self.builder.ins().iconst(types::I64, value),
            Inst::Bool(value) => self.builder.ins().iconst(types::I8, i64::from(value)),
            Inst::IntOfBool(val) => {
                let value = self.value(val);
                self.builder.ins().uextend(types::I64, value)
            }
            Inst::Scalar(op, [a, b]) => self.scalar(op, self.value(a), self.value(b)),
            Inst::Checked { index, length } => self.checked(index, length),
            Inst::Offset { offset, index, stride } => self.offset(offset, index, stride),
            Inst::Entry { table, start, column } => self.entry_of_table(table, start, column),
            Inst::Abs(val) => self.abs(self.value(val)),
            Inst::Require(relation, [a, b]) => {
                let (a, b) = (self.value(a), self.value(b));
                let otherwise = match relation {
                    Relation::Less => FloatCC::UnorderedOrGreaterThanOrEqual,
                    Relation::AtMost => FloatCC::UnorderedOrGreaterThan,
                };
                let is_otherwise = self.builder.ins().fcmp(otherwise, a, b);
                self.leave_if(is_otherwise);
                a
            }
            Inst::Decided(val) => self.decided(val),
        }
    }

    /// Takes a decision into account, as [`Decisions::with`] does.
    fn decided(&mut self, val: Val) -> ir::Value {
        let value = self.value(val);
        let decision = match self.body.type_of(val) {
            Type::Int => value,
            Type::Bool => self.builder.ins().uextend(types::I64, value),
            // Toward 0, and as `as` does where that is no integer.
            Type::Real => self.builder.ins().fcvt_to_sint_sat(types::I64, value),
        };
        let variable = self.decisions.expect("only signed shaders have decisions");
        let so_far = self.builder.use_var(variable);
        let turned = self.builder.ins().rotl_imm_u(so_far, i64::from(Decisions::TURN));
        let mixed = self.builder.ins().bxor(turned, decision);
        let factor = self.builder.ins().iconst(types::I64, Decisions::FACTOR as i64);
        let with = self.builder.ins().imul(mixed, factor);
        self.builder.def_var(variable, with);
        value
    }
}
