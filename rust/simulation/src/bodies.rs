//! Bodies in the state of a frame: how many there are (u32), and of each its turn (four f32), how far it has moved, its
//! velocity and spin (three f32 each) and the two momenta that it is yet to get (three f64 each), little-endian.

use glam::{DVec3, Quat, Vec3};
use relievo_core::{Error, Result};
use relievo_fluid::BodyState;

/// Numbers of f32, and bytes of them and of those of f64.
const SINGLES: usize = 13;
const BODY: usize = 4 * SINGLES + 6 * 8;

pub fn encode(bodies: &[BodyState]) -> Vec<u8> {
    let mut out = (bodies.len() as u32).to_le_bytes().to_vec();
    for BodyState { pose: (turn, moved), velocity, spin, due } in bodies {
        out.extend(turn.to_array().iter().flat_map(|value| value.to_le_bytes()));
        out.extend([moved, velocity, spin].iter().flat_map(|it| it.to_array()).flat_map(f32::to_le_bytes));
        out.extend(due.iter().flat_map(|it| it.to_array()).flat_map(f64::to_le_bytes));
    }
    out
}

/// Fails unless there are as many bytes as bodies need.
pub fn decode(bytes: &[u8]) -> Result<Vec<BodyState>> {
    let unfit = || Error::invalid("its state has not the bytes that bodies need").advise("begin anew by --restart");
    let (count, bytes) = bytes.split_first_chunk().ok_or_else(unfit)?;
    let (bodies, left) = bytes.as_chunks::<BODY>();
    if bodies.len() as u64 != u64::from(u32::from_le_bytes(*count)) || !left.is_empty() {
        return Err(unfit());
    }
    let body = |bytes: &[u8; BODY]| {
        let (singles, doubles) = bytes.split_at(4 * SINGLES);
        let single = |at: usize| f32::from_le_bytes(singles.as_chunks().0[at]);
        let vector = |at: usize| Vec3::new(single(at), single(at + 1), single(at + 2));
        let double = |at: usize| f64::from_le_bytes(doubles.as_chunks().0[at]);
        let momentum = |at: usize| DVec3::new(double(at), double(at + 1), double(at + 2));
        let turn = Quat::from_xyzw(single(0), single(1), single(2), single(3));
        let (velocity, spin) = (vector(7), vector(10));
        BodyState { pose: (turn, vector(4)), velocity, spin, due: [momentum(0), momentum(3)] }
    };
    Ok(bodies.iter().map(body).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_what_is_cut_or_longer_is_not() {
        let pose = (Quat::from_rotation_x(0.5), Vec3::new(1.0, 2.0, 3.0));
        let due = [DVec3::splat(0.1), DVec3::new(4.0, -5.0, 1e-9)];
        let bodies = [BodyState { pose, velocity: Vec3::Y, spin: Vec3::NEG_X, due }, BodyState::default()];
        let bytes = encode(&bodies);
        assert_eq!(decode(&bytes).unwrap(), bodies);
        assert!((0..bytes.len()).all(|length| decode(&bytes[..length]).is_err()));
        assert!(decode(&[&bytes[..], &[0]].concat()).is_err());
    }
}
