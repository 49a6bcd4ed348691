//! The operators that make objects and lights, and `render`: operands from the operand stack.

use std::sync::Arc;

use compiler::bytecode::Origin;
use compiler::op::{Operator, Type};
use compiler::scalar::Point;
use glam::DVec3;
use renderer::light::Light;
use renderer::object::{Object, ShapeKind, TransformOp};

use crate::error::Problem;
use crate::heap::OBJECT_BYTES;
use crate::host::{Host, RenderJob};
use crate::machine::Machine;
use crate::value::{Closure, Value};
use crate::word::{Tag, Word};

type Solid = Object<Arc<Closure>>;
type Outcome<T> = Result<T, Box<Problem>>;

/// Performs an operator; `render` has no result.
pub(crate) fn operate(
    op: Operator,
    machine: &mut Machine<'_>,
    origin: Origin,
    host: &mut Option<&mut dyn Host>,
) -> Outcome<Option<Word>> {
    if op == Operator::Render {
        render(machine, origin, host)?;
        return Ok(None);
    }
    let made = make(op, &take(op, machine)?)?;
    let tag = if let Value::Light(_) = made { Tag::Light } else { Tag::Object };
    Ok(Some(machine.heap.adopt(tag, made, OBJECT_BYTES)))
}

/// Takes the operands from the stack, bottom first.
fn take(op: Operator, machine: &mut Machine<'_>) -> Outcome<Vec<Value>> {
    let n_operands = op.operands().len();
    if machine.stack.len() - machine.floor < n_operands {
        return Err(Box::new(Problem::Underflow(Some(op), 0)));
    }
    Ok(machine.take_values(machine.stack.len() - n_operands))
}

fn make(op: Operator, operands: &[Value]) -> Outcome<Value> {
    let shape = |kind| match operands {
        [Value::Closure(surface)] => Ok(Value::Object(Object::shape(kind, surface.clone()))),
        _ => Err(mismatch(op, operands)),
    };
    match op {
        Operator::Sphere => shape(ShapeKind::Sphere),
        Operator::Cube => shape(ShapeKind::Cube),
        Operator::Cylinder => shape(ShapeKind::Cylinder),
        Operator::Cone => shape(ShapeKind::Cone),
        Operator::Plane => shape(ShapeKind::Plane),
        Operator::Union => combine(op, operands, Object::union),
        Operator::Intersect => combine(op, operands, Object::intersect),
        Operator::Difference => combine(op, operands, Object::difference),
        Operator::Light | Operator::PointLight | Operator::SpotLight => light(op, operands),
        _ => transform(op, operands),
    }
}

fn combine(op: Operator, operands: &[Value], how: fn(&Solid, &Solid) -> Solid) -> Outcome<Value> {
    match operands {
        [Value::Object(a), Value::Object(b)] => Ok(Value::Object(how(a, b))),
        _ => Err(mismatch(op, operands)),
    }
}

fn transform(op: Operator, operands: &[Value]) -> Outcome<Value> {
    let (object, how) = match (op, operands) {
        (
            Operator::Translate,
            [Value::Object(o), Value::Real(x), Value::Real(y), Value::Real(z)],
        ) => (o, TransformOp::Translate(DVec3::new(*x, *y, *z))),
        (Operator::Scale, [Value::Object(o), Value::Real(x), Value::Real(y), Value::Real(z)]) => {
            (o, TransformOp::Scale(DVec3::new(*x, *y, *z)))
        }
        (Operator::UScale, [Value::Object(o), Value::Real(s)]) => {
            (o, TransformOp::Scale(DVec3::splat(*s)))
        }
        (Operator::RotateX, [Value::Object(o), Value::Real(angle)]) => {
            (o, TransformOp::RotateX(*angle))
        }
        (Operator::RotateY, [Value::Object(o), Value::Real(angle)]) => {
            (o, TransformOp::RotateY(*angle))
        }
        (Operator::RotateZ, [Value::Object(o), Value::Real(angle)]) => {
            (o, TransformOp::RotateZ(*angle))
        }
        _ => return Err(mismatch(op, operands)),
    };
    let transformed =
        object.transformed(how).map_err(|error| Box::new(Problem::Transform(op, error)))?;
    Ok(Value::Object(transformed))
}

fn light(op: Operator, operands: &[Value]) -> Outcome<Value> {
    let light = match operands {
        [Value::Point(dir), Value::Point(color)] if op == Operator::Light => {
            Light::Directional { dir: vector(*dir), color: vector(*color) }
        }
        [Value::Point(position), Value::Point(color)] => {
            Light::Point { position: vector(*position), color: vector(*color) }
        }
        [
            Value::Point(position),
            Value::Point(at),
            Value::Point(color),
            Value::Real(cutoff),
            Value::Real(exponent),
        ] => Light::Spot {
            position: vector(*position),
            at: vector(*at),
            color: vector(*color),
            cutoff_deg: *cutoff,
            exponent: *exponent,
        },
        _ => return Err(mismatch(op, operands)),
    };
    Ok(Value::Light(Arc::new(light)))
}

/// A GML point as a vector.
#[must_use]
pub(crate) fn vector(point: Point) -> DVec3 {
    DVec3::from_array(point)
}

fn mismatch(op: Operator, operands: &[Value]) -> Box<Problem> {
    Box::new(Problem::Mismatch(op, operands.iter().map(Value::type_of).collect()))
}

/// Takes the operands of `render`. Below the object lies the array of lights (ICFP dialect) or the
/// attenuation point, then the lights (Chicago dialect).
fn render(
    machine: &mut Machine<'_>,
    origin: Origin,
    host: &mut Option<&mut dyn Host>,
) -> Outcome<()> {
    let Some(host) = host.as_mut() else { return Err(Box::new(Problem::RenderInSurface)) };
    let n_reachable = machine.stack.len() - machine.floor;
    let lights_at = machine.stack.len().wrapping_sub(7);
    let is_chicago = n_reachable >= 7 && machine.stack.as_slice()[lights_at].tag == Tag::Point;
    let n_operands = if is_chicago { 9 } else { 8 };
    if n_reachable < n_operands {
        return Err(Box::new(Problem::Underflow(Some(Operator::Render), 0)));
    }
    let mut operands = machine.take_values(machine.stack.len() - n_operands);
    let attenuation = if is_chicago { operands[2].clone() } else { Value::Bool(false) };
    if is_chicago {
        operands.remove(2);
    }
    let attenuation = if let Value::Point(point) = attenuation { Some(point) } else { None };
    let [
        Value::Point(ambient),
        Value::Array(lights),
        Value::Object(object),
        Value::Int(depth),
        Value::Real(fov_deg),
        Value::Int(width),
        Value::Int(height),
        Value::Str(name),
    ] = &operands[..]
    else {
        return Err(mismatch(Operator::Render, &operands));
    };
    let job = RenderJob {
        program: machine.program,
        ambient: *ambient,
        lights: lights.items().iter().enumerate().map(as_light).collect::<Outcome<_>>()?,
        attenuation,
        object: object.clone(),
        depth: u32::try_from((*depth).max(0)).unwrap_or(u32::MAX),
        fov_deg: field_of_view(*fov_deg)?,
        width: size("width", *width)?,
        height: size("height", *height)?,
        name: name.clone(),
        origin,
    };
    host.render(job).map_err(|diagnostic| Box::new(Problem::Host(diagnostic)))
}

fn as_light((index, value): (usize, &Value)) -> Outcome<Light> {
    match value {
        Value::Light(light) => Ok(Light::clone(light)),
        other => {
            let found = other.type_of().with_article();
            let text = format!(
                "element {index} of the array of lights is {found}, not {}",
                Type::Light.with_article()
            );
            Err(Box::new(Problem::Render(text)))
        }
    }
}

fn field_of_view(degrees: f64) -> Outcome<f64> {
    if degrees > 0.0 && degrees < 180.0 {
        return Ok(degrees);
    }
    let text =
        format!("the field of view is {degrees:?} degrees; it must lie above 0 and below 180");
    Err(Box::new(Problem::Render(text)))
}

fn size(what: &str, value: i64) -> Outcome<u32> {
    match u32::try_from(value) {
        Ok(size) if size > 0 => Ok(size),
        _ => {
            let text = format!("the image's {what} is {value}; it must be from 1 to {}", u32::MAX);
            Err(Box::new(Problem::Render(text)))
        }
    }
}
