//! The characteristic polynomial of a rational matrix.

use num_rational::BigRational;
use num_traits::{One, Zero};

use crate::rational::{product, sum};
use crate::univariate::Univariate;

/// `det(x - A)`: by similar matrices down to Hessenberg form, then by its leading minors; none where the work is to end.
pub(super) fn characteristic(matrix: &[Vec<BigRational>], stop: &dyn Fn() -> bool) -> Option<Univariate> {
    let size = matrix.len();
    let mut a = matrix.to_vec();
    for column in 0..size.saturating_sub(2) {
        let Some(pivot) = (column + 1..size).find(|row| !a[*row][column].is_zero()) else { continue };
        if pivot != column + 1 {
            a.swap(pivot, column + 1);
            a.iter_mut().for_each(|row| row.swap(pivot, column + 1));
        }
        for row in column + 2..size {
            if stop() {
                return None;
            }
            if a[row][column].is_zero() {
                continue;
            }
            let factor = product(&a[row][column], &a[column + 1][column].recip());
            let pivot = a[column + 1].clone();
            for (number, other) in a[row].iter_mut().zip(&pivot).skip(column).filter(|(_, other)| !other.is_zero()) {
                *number = sum(number, &-product(&factor, other));
            }
            for other in &mut a {
                if !other[row].is_zero() {
                    let change = product(&factor, &other[row]);
                    other[column + 1] = sum(&other[column + 1], &change);
                }
            }
        }
    }
    let mut minors = vec![Univariate::one()];
    for size in 0..size {
        if stop() {
            return None;
        }
        let mut minor = minors[size].times(&Univariate::root(&a[size][size]));
        let mut below = BigRational::one();
        for back in (0..size).rev() {
            below = product(&below, &a[back + 1][back]);
            if below.is_zero() {
                break;
            }
            minor = minor.minus(&minors[back].scale(&product(&below, &a[back][size])));
        }
        minors.push(minor);
    }
    minors.pop()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_matrix_is_a_root_of_its_polynomial() {
        let mut seed = 7i64;
        let mut next = || {
            seed = (seed * 1_103_515_245 + 12_345) % 2_147_483_648;
            BigRational::new((seed / 65_536 % 7 - 3).into(), (seed / 1024 % 3 + 1).into())
        };
        for size in 1..6usize {
            let matrix: Vec<Vec<BigRational>> = (0..size).map(|_| (0..size).map(|_| next()).collect()).collect();
            let polynomial = characteristic(&matrix, &|| false).unwrap();
            let mut sum = vec![vec![BigRational::zero(); size]; size];
            for coefficient in polynomial.coefficients().iter().rev() {
                let mut product = vec![vec![BigRational::zero(); size]; size];
                for row in 0..size {
                    for column in 0..size {
                        for at in 0..size {
                            product[row][column] += &sum[row][at] * &matrix[at][column];
                        }
                    }
                    product[row][row] += coefficient;
                }
                sum = product;
            }
            assert!(sum.iter().flatten().all(BigRational::is_zero));
        }
    }
}
