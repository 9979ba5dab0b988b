//! SHA-256 (FIPS 180-4), for the hash of a scene.

use std::sync::LazyLock;

/// Constants of the rounds, and the hash of nothing.
static CONSTANTS: LazyLock<[Vec<u32>; 2]> =
    LazyLock::new(|| [fractions(64, f64::cbrt), fractions(8, f64::sqrt)]);

/// Returns the first 32 bits of the fraction of a root, for each of the first primes. With wrong roots, no hash would be right.
fn fractions(count: usize, root: fn(f64) -> f64) -> Vec<u32> {
    let is_prime = |n: &u32| (2..*n).all(|d| !n.is_multiple_of(d));
    let primes = (2..).filter(is_prime).take(count);
    primes.map(|prime| (root(f64::from(prime)).fract() * 4_294_967_296.0) as u32).collect()
}

/// Returns the hash of some bytes, as 64 hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let [k, mut h] = CONSTANTS.each_ref().map(Vec::clone);
    let mut rest = bytes.chunks_exact(64).remainder().to_vec();
    rest.push(0x80);
    rest.resize((rest.len() + 8).next_multiple_of(64) - 8, 0);
    rest.extend((8 * bytes.len() as u64).to_be_bytes());
    for block in bytes.chunks_exact(64).chain(rest.chunks_exact(64)) {
        let word = |b: &[u8]| b.iter().fold(0, |word: u32, byte| word << 8 | u32::from(*byte));
        let mut w: Vec<u32> = block.chunks_exact(4).map(word).collect();
        for t in 16..64 {
            let (a, b) = (w[t - 15], w[t - 2]);
            let s0 = a.rotate_right(7) ^ a.rotate_right(18) ^ a >> 3;
            let s1 = b.rotate_right(17) ^ b.rotate_right(19) ^ b >> 10;
            w.push(w[t - 16].wrapping_add(s0).wrapping_add(w[t - 7]).wrapping_add(s1));
        }
        let mut v: [u32; 8] = std::array::from_fn(|i| h[i]);
        for t in 0..64 {
            let s1 = v[4].rotate_right(6) ^ v[4].rotate_right(11) ^ v[4].rotate_right(25);
            let choice = v[4] & v[5] ^ !v[4] & v[6];
            let first = v[7].wrapping_add(s1).wrapping_add(choice).wrapping_add(k[t]).wrapping_add(w[t]);
            let s0 = v[0].rotate_right(2) ^ v[0].rotate_right(13) ^ v[0].rotate_right(22);
            let majority = v[0] & v[1] ^ v[0] & v[2] ^ v[1] & v[2];
            let last = first.wrapping_add(s0).wrapping_add(majority);
            v = [last, v[0], v[1], v[2], v[3].wrapping_add(first), v[4], v[5], v[6]];
        }
        h = h.iter().zip(&v).map(|(a, b)| a.wrapping_add(*b)).collect();
    }
    h.iter().map(|word| format!("{word:08x}")).collect()
}
