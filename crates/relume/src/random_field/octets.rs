//! Vectors of eight numbers: processor vectors where available, eight single numbers elsewhere. Both round
//! alike, so results are identical to the bit.

/// Numbers in a vector.
pub const OCTET: usize = 8;

/// The operations on vectors of eight numbers.
pub trait Octets: Copy {
    /// The vector.
    type Vector: Copy;
    /// The same number eight times.
    fn splat(self, value: f32) -> Self::Vector;
    /// Loads eight consecutive numbers.
    fn load(self, values: &[f32]) -> Self::Vector;
    /// Writes eight consecutive numbers.
    fn store(self, vector: Self::Vector, values: &mut [f32]);
    /// a b + c, rounded once.
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector;
}

/// Without special instructions.
#[derive(Clone, Copy)]
pub struct PortableOctets;

impl Octets for PortableOctets {
    type Vector = [f32; OCTET];

    fn splat(self, value: f32) -> Self::Vector {
        [value; OCTET]
    }

    fn load(self, values: &[f32]) -> Self::Vector {
        values.try_into().expect("eight numbers")
    }

    fn store(self, vector: Self::Vector, values: &mut [f32]) {
        values.copy_from_slice(&vector);
    }

    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        std::array::from_fn(|i| a[i].mul_add(b[i], c[i]))
    }
}

#[cfg(target_arch = "x86_64")]
impl Octets for pulp::x86::V3 {
    type Vector = pulp::f32x8;

    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        self.splat_f32x8(value)
    }

    #[inline(always)]
    fn load(self, values: &[f32]) -> Self::Vector {
        let values: [f32; OCTET] = values.try_into().expect("eight numbers");
        bytemuck::must_cast(values)
    }

    #[inline(always)]
    fn store(self, vector: Self::Vector, values: &mut [f32]) {
        let vector: [f32; OCTET] = bytemuck::must_cast(vector);
        values.copy_from_slice(&vector);
    }

    #[inline(always)]
    fn mul_add(self, a: Self::Vector, b: Self::Vector, c: Self::Vector) -> Self::Vector {
        self.mul_add_f32x8(a, b, c)
    }
}
