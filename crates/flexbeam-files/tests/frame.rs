//! The wire frame: every byte where the book says, every change noticed, any bytes survived.

use flexbeam_files::frame::{
    COMMAND_BYTES, Command, FrameError, MEASUREMENT_BYTES, Measurement, VERSION, is_command, is_sealed,
};
use proptest::prelude::*;

/// The check sum by its definition, bit by bit: reflected polynomial EDB88320, all ones before and after.
fn crc32(bytes: &[u8]) -> u32 {
    let bit = |crc: u32| if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| bit(crc)))
}

fn with_seal(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let seal = crc32(&bytes[..body]);
    bytes[body..].copy_from_slice(&seal.to_le_bytes());
    bytes
}

const COMMAND: Command =
    Command { session: 0x0403_0201, sequence: 0x0807_0605, hold_ms: 0x0A09, flags: 1, voltage_v: -2.5 };

const MEASUREMENT: Measurement = Measurement {
    session: 0x0403_0201,
    sequence: 0x0807_0605,
    status: 5,
    theta_rad: 1.0,
    alpha_rad: -0.5,
    boots: 0x0C0B_0A09,
};

#[test]
fn the_check_sum_has_the_standard_s_check_value() {
    assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
}

#[test]
fn a_command_has_its_bytes_where_the_book_says() {
    let body: [u8; 28] =
        [b'F', b'B', 1, 1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1, 0, 0, 0, 0, 0, 0, 0, 0x04, 0xC0, 0, 0, 0, 0];
    let bytes = COMMAND.encode();
    assert_eq!(bytes[..28], body);
    assert_eq!(bytes[28..], crc32(&body).to_le_bytes());
}

#[test]
fn a_measurement_has_its_bytes_where_the_book_says() {
    let body: [u8; 36] = [
        b'F', b'B', 1, 2, 1, 2, 3, 4, 5, 6, 7, 8, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xF0, 0x3F, 0, 0, 0, 0, 0, 0, 0xE0,
        0xBF, 9, 10, 11, 12,
    ];
    let bytes = MEASUREMENT.encode();
    assert_eq!(bytes[..36], body);
    assert_eq!(bytes[36..], crc32(&body).to_le_bytes());
}

#[test]
fn each_fault_is_named() {
    let good = COMMAND.encode();
    let with = |at: usize, value: u8| {
        let mut bytes = good;
        bytes[at] = value;
        Command::decode(&bytes)
    };
    assert_eq!(with(0, b'G'), Err(FrameError::Magic));
    assert_eq!(with(2, 2), Err(FrameError::Version { found: 2 }));
    assert_eq!(with(16, 1), Err(FrameError::Checksum));
    assert_eq!(Command::decode(&good[..31]), Err(FrameError::Length { found: 31 }));
    assert_eq!(Command::decode(&[]), Err(FrameError::Length { found: 0 }));
    assert_eq!(Command::decode(&MEASUREMENT.encode()), Err(FrameError::Kind { found: 2 }));
    assert_eq!(Measurement::decode(&good), Err(FrameError::Kind { found: 1 }));
    let mut long = good.to_vec();
    long.resize(MEASUREMENT_BYTES, 0);
    assert_eq!(Command::decode(&with_seal(long)), Err(FrameError::Length { found: MEASUREMENT_BYTES }));
}

#[test]
fn a_newer_frame_is_named_whatever_its_size_and_believed_when_its_seal_holds() {
    for length in [8, COMMAND_BYTES, 100] {
        let mut bytes = vec![7; length];
        bytes[..3].copy_from_slice(&[b'F', b'B', VERSION + 1]);
        assert_eq!(Measurement::decode(&bytes), Err(FrameError::Version { found: VERSION + 1 }));
        assert!(!is_sealed(&bytes));
        assert!(is_sealed(&with_seal(bytes)));
    }
    assert!(!is_sealed(&[1, 2, 3]));
}

#[test]
fn a_host_s_frame_of_any_version_is_told_from_a_rig_s() {
    assert!(is_command(&COMMAND.encode()));
    assert!(!is_command(&MEASUREMENT.encode()));
    assert!(is_command(&with_seal(vec![b'F', b'B', 200, 1, 0, 0, 0, 0])));
    assert!(!is_command(&[b'F', b'B', 200, 1, 0, 0, 0, 0]), "not sealed");
    assert!(!is_command(&with_seal(vec![b'G', b'B', 200, 1, 0, 0, 0, 0])));
}

#[test]
fn what_a_later_version_may_put_into_the_reserved_bytes_is_passed_over() {
    let mut bytes = COMMAND.encode().to_vec();
    bytes[24..28].fill(0xAA);
    assert_eq!(Command::decode(&with_seal(bytes)), Ok(COMMAND));
}

fn command() -> impl Strategy<Value = Command> {
    (any::<u32>(), any::<u32>(), any::<u16>(), any::<u16>(), any::<u64>()).prop_map(
        |(session, sequence, hold_ms, flags, bits)| Command {
            session,
            sequence,
            hold_ms,
            flags,
            voltage_v: f64::from_bits(bits),
        },
    )
}

fn measurement() -> impl Strategy<Value = Measurement> {
    (any::<[u32; 4]>(), any::<[u64; 2]>()).prop_map(|([session, sequence, status, boots], angles)| {
        let [theta_rad, alpha_rad] = angles.map(f64::from_bits);
        Measurement { session, sequence, status, theta_rad, alpha_rad, boots }
    })
}

proptest! {
    /// Compared as bytes, since an undefined number does not equal itself.
    #[test]
    fn what_was_sent_arrives(command in command(), measurement in measurement()) {
        let sent = command.encode();
        prop_assert_eq!(Command::decode(&sent).map(|c| c.encode()), Ok(sent));
        let sent = measurement.encode();
        prop_assert_eq!(Measurement::decode(&sent).map(|m| m.encode()), Ok(sent));
    }

    /// Up to 32 bits in a row: the check sum finds each of them for certain.
    #[test]
    fn a_burst_of_errors_is_noticed(command in command(), at in 0..COMMAND_BYTES - 4, burst in 1..=u32::MAX) {
        let mut bytes = command.encode();
        bytes[at..].iter_mut().zip(burst.to_le_bytes()).for_each(|(byte, wrong)| *byte ^= wrong);
        prop_assert!(Command::decode(&bytes).is_err());
    }

    #[test]
    fn any_bytes_are_survived(bytes in proptest::collection::vec(any::<u8>(), 0..80)) {
        let _ = is_sealed(&bytes);
        prop_assert!(Command::decode(&bytes).is_err());
        prop_assert!(Measurement::decode(&bytes).is_err());
    }
}
