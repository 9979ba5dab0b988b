//! SHA-256 (FIPS 180-4), for the hash of a scene.

/// Primes from 2 on, whose roots give the constants.
fn primes(count: usize) -> Vec<u64> {
    let is_prime = |n: &u64| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0);
    (2..).filter(is_prime).take(count).collect()
}

/// Returns the first 32 bits of the fraction of the root of this degree.
fn fraction(prime: u64, degree: u32) -> u32 {
    // Greatest r with r^degree <= prime · 2^(32·degree).
    let target = u128::from(prime) << (32 * degree);
    let mut root: u128 = 0;
    for bit in (0..36).rev() {
        let next = root | 1 << bit;
        if next.pow(degree) <= target {
            root = next;
        }
    }
    root as u32
}

/// Returns the hash of some bytes, as 64 hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let k: Vec<u32> = primes(64).into_iter().map(|prime| fraction(prime, 3)).collect();
    let mut h: Vec<u32> = primes(8).into_iter().map(|prime| fraction(prime, 2)).collect();
    let mut rest = bytes.chunks_exact(64).remainder().to_vec();
    rest.push(0x80);
    while rest.len() % 64 != 56 {
        rest.push(0);
    }
    rest.extend((8 * bytes.len() as u64).to_be_bytes());
    for block in bytes.chunks_exact(64).chain(rest.chunks_exact(64)) {
        let mut w: Vec<u32> =
            block.chunks_exact(4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]])).collect();
        for t in 16..64 {
            let (a, b) = (w[t - 15], w[t - 2]);
            let s0 = a.rotate_right(7) ^ a.rotate_right(18) ^ a >> 3;
            let s1 = b.rotate_right(17) ^ b.rotate_right(19) ^ b >> 10;
            w.push(w[t - 16].wrapping_add(s0).wrapping_add(w[t - 7]).wrapping_add(s1));
        }
        let mut v = h.clone();
        for t in 0..64 {
            let s1 = v[4].rotate_right(6) ^ v[4].rotate_right(11) ^ v[4].rotate_right(25);
            let choice = v[4] & v[5] ^ !v[4] & v[6];
            let first = v[7].wrapping_add(s1).wrapping_add(choice).wrapping_add(k[t]).wrapping_add(w[t]);
            let s0 = v[0].rotate_right(2) ^ v[0].rotate_right(13) ^ v[0].rotate_right(22);
            let majority = v[0] & v[1] ^ v[0] & v[2] ^ v[1] & v[2];
            v.rotate_right(1);
            v[4] = v[4].wrapping_add(first);
            v[0] = first.wrapping_add(s0).wrapping_add(majority);
        }
        h = h.iter().zip(&v).map(|(a, b)| a.wrapping_add(*b)).collect();
    }
    h.iter().map(|word| format!("{word:08x}")).collect()
}
