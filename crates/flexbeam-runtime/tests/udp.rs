//! A rig behind UDP on this machine.

mod support;

use flexbeam_runtime::back_end::{Answer, BackEnd, Counters, LinkFault};
use flexbeam_runtime::served_rig::{OnSession, ServeOptions};
use flexbeam_runtime::udp::{UdpRig, UdpRigWire};
use support::{PATIENT, Serving, bits, exchanges, in_process};

fn served(options: ServeOptions) -> (Serving, String) {
    let wire = UdpRigWire::bind("127.0.0.1:0").unwrap();
    let address = wire.address().unwrap().to_string();
    (Serving::start(wire, options), address)
}

#[test]
fn two_thousand_exchanges_give_the_bits_of_a_rig_in_the_process() {
    let (serving, address) = served(ServeOptions::default());
    let expected = in_process(2000);
    // Twice, since a new session puts the rig back to rest.
    let mut host = UdpRig::open(&address, 1).unwrap();
    for _ in 0..2 {
        host.prepare(PATIENT).unwrap();
        for (k, (answer, expected)) in exchanges(&mut host, 2000).into_iter().zip(&expected).enumerate() {
            let Ok(Answer::Fresh(found)) = answer else { panic!("{k}: {answer:?}") };
            assert_eq!(bits(found), bits(*expected), "instant {k}");
        }
        host.zero().unwrap();
        assert_eq!(host.counters(), Counters::default());
    }
    let report = serving.end();
    assert_eq!(report.counts.runs, 2);
}
