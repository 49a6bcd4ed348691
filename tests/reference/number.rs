//! Numbers of 256 bits, and vectors and affine maps of them, by their definitions.

use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use renderer::object::TransformOp;

pub(crate) type Big = FBig<HalfEven>;

/// Bits of a number.
const BITS: usize = 256;

/// What is smaller by this factor than the terms it was computed from is 0: of 256 bits, 76 are
/// left for the roundings of a whole computation.
pub(crate) const NOTHING: f64 = 6.5e-55;

pub(crate) fn big(value: f64) -> Big {
    Big::try_from(value).expect("a finite number").with_precision(BITS).value()
}

pub(crate) fn to_f64(value: &Big) -> f64 {
    value.to_f64().value()
}

/// The number, by the way of its sign and size.
pub(crate) fn is_positive(value: &Big) -> bool {
    *value > Big::ZERO
}

/// `base` to the power of `exponent`, for a base that is not negative.
pub(crate) fn power(base: &Big, exponent: f64) -> Big {
    if exponent == 0.0 {
        return big(1.0);
    }
    if *base == Big::ZERO {
        return big(0.0);
    }
    if exponent.trunc() == exponent && exponent.abs() < 1e6 {
        return base.powi((exponent as i64).into());
    }
    base.powf(&big(exponent))
}

/// Sine and cosine of an angle in degrees.
pub(crate) fn sin_cos_degrees(angle: f64) -> (Big, Big) {
    (big(angle) * Big::pi(BITS) / big(180.0)).sin_cos()
}

/// The angle of a point around the y axis, from +z toward +x, in turns from 0 to 1.
pub(crate) fn turns(x: &Big, z: &Big) -> Big {
    if *x == Big::ZERO && *z == Big::ZERO {
        return big(0.0);
    }
    let turns = x.atan2(z) / (Big::pi(BITS) * big(2.0));
    if turns < Big::ZERO { turns + big(1.0) } else { turns }
}

/// A point, a vector or a colour.
#[derive(Clone, Debug)]
pub(crate) struct Vector(pub(crate) [Big; 3]);

impl Vector {
    pub(crate) fn from_f64s(v: [f64; 3]) -> Self {
        Vector(v.map(big))
    }

    pub(crate) fn zero() -> Self {
        Vector::from_f64s([0.0; 3])
    }

    pub(crate) fn zip(&self, other: &Vector, f: impl Fn(&Big, &Big) -> Big) -> Vector {
        Vector(std::array::from_fn(|i| f(&self.0[i], &other.0[i])))
    }

    pub(crate) fn plus(&self, other: &Vector) -> Vector {
        self.zip(other, |a, b| a + b)
    }

    pub(crate) fn minus(&self, other: &Vector) -> Vector {
        self.zip(other, |a, b| a - b)
    }

    pub(crate) fn by_component(&self, other: &Vector) -> Vector {
        self.zip(other, |a, b| a * b)
    }

    pub(crate) fn times(&self, factor: &Big) -> Vector {
        Vector(self.0.each_ref().map(|a| a * factor))
    }

    pub(crate) fn dot(&self, other: &Vector) -> Big {
        let [x, y, z] = self.by_component(other).0;
        x + y + z
    }

    pub(crate) fn length(&self) -> Big {
        self.dot(self).sqrt()
    }

    /// The vector of length 1; none for the zero vector.
    pub(crate) fn unit(&self) -> Option<Vector> {
        let length = self.length();
        is_positive(&length).then(|| Vector(self.0.each_ref().map(|a| a / &length)))
    }

    /// The size of the largest component.
    pub(crate) fn size(&self) -> f64 {
        self.0.iter().fold(0.0, |size, a| to_f64(a).abs().max(size))
    }
}

/// `p -> matrix p + shift`.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    pub(crate) rows: [Vector; 3],
    pub(crate) shift: Vector,
}

impl Map {
    pub(crate) fn identity() -> Self {
        Map::scale([1.0; 3])
    }

    fn scale(by: [f64; 3]) -> Self {
        let row = |i: usize| {
            let mut row = [0.0; 3];
            row[i] = by[i];
            Vector::from_f64s(row)
        };
        Map { rows: [row(0), row(1), row(2)], shift: Vector::zero() }
    }

    /// The rotation from axis `i` toward axis `j`.
    fn rotation(angle: f64, i: usize, j: usize) -> Self {
        let (sin, cos) = sin_cos_degrees(angle);
        let mut map = Map::identity();
        map.rows[i].0[i] = cos.clone();
        map.rows[j].0[j] = cos;
        map.rows[i].0[j] = -sin.clone();
        map.rows[j].0[i] = sin;
        map
    }

    pub(crate) fn of(op: TransformOp) -> Self {
        match op {
            TransformOp::Translate(by) => {
                Map { shift: Vector::from_f64s(by.to_array()), ..Map::identity() }
            }
            TransformOp::Scale(by) => Map::scale(by.to_array()),
            TransformOp::RotateX(angle) => Map::rotation(angle, 1, 2),
            TransformOp::RotateY(angle) => Map::rotation(angle, 2, 0),
            TransformOp::RotateZ(angle) => Map::rotation(angle, 0, 1),
        }
    }

    /// The map that does `first`, then this.
    pub(crate) fn after(&self, first: &Map) -> Map {
        let column = |k: usize| {
            let column = Vector(std::array::from_fn(|i| first.rows[i].0[k].clone()));
            self.vector(&column)
        };
        let columns = [column(0), column(1), column(2)];
        let row = |i: usize| Vector(std::array::from_fn(|k| columns[k].0[i].clone()));
        Map { rows: [row(0), row(1), row(2)], shift: self.point(&first.shift) }
    }

    /// By cofactors.
    pub(crate) fn inverse(&self) -> Map {
        let entry = |i: usize, j: usize| &self.rows[i % 3].0[j % 3];
        let cofactor = |i: usize, j: usize| {
            entry(i + 1, j + 1) * entry(i + 2, j + 2) - entry(i + 1, j + 2) * entry(i + 2, j + 1)
        };
        let determinant: Big =
            (0..3).map(|j| entry(0, j) * cofactor(0, j)).fold(big(0.0), |a, b| a + b);
        let row = |i: usize| Vector(std::array::from_fn(|j| cofactor(j, i) / &determinant));
        let mut inverse = Map { rows: [row(0), row(1), row(2)], shift: Vector::zero() };
        inverse.shift = Vector::zero().minus(&inverse.vector(&self.shift));
        inverse
    }

    pub(crate) fn vector(&self, v: &Vector) -> Vector {
        Vector(self.rows.each_ref().map(|row| row.dot(v)))
    }

    pub(crate) fn point(&self, p: &Vector) -> Vector {
        self.vector(p).plus(&self.shift)
    }

    /// The transposed matrix times a vector.
    pub(crate) fn transposed(&self, v: &Vector) -> Vector {
        let [x, y, z] = &self.rows;
        x.times(&v.0[0]).plus(&y.times(&v.0[1])).plus(&z.times(&v.0[2]))
    }

    /// The largest sum of the sizes of a row's entries.
    pub(crate) fn size(&self) -> f64 {
        let of_row = |row: &Vector| row.0.iter().map(|entry| to_f64(entry).abs()).sum::<f64>();
        self.rows.iter().map(of_row).fold(0.0, f64::max)
    }
}
