//! Domains of one fluid that are connected by TCP.

use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use relievo_client::{Address, MAX_PART, Nothing, notification, request};
use relievo_core::{Context, Error, Result};
use relievo_fluid::{Checkpoint, InProcess, Transport};
use relievo_server::{RankOptions, RpcRanks};
use relievo_simulation::{Description, Making, Simulation, in_folder};

use super::DAM;

/// Returns free addresses of this machine. Their ports are below the ephemeral ones, so that no connection of another test takes
/// them before the rank does.
fn addresses(count: usize) -> Vec<Address> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let free = || loop {
        let number = 64 * std::process::id() + NEXT.fetch_add(1, Ordering::Relaxed);
        let port = 12_000 + (number % 20_000) as u16;
        if TcpListener::bind(("127.0.0.1", port)).is_ok() {
            break port;
        }
    };
    (0..count).map(|_| Address::Tcp { host: "127.0.0.1".into(), port: free(), tls: false }).collect()
}

fn options(addresses: &[Address], rank: usize) -> RankOptions {
    let joining = Duration::from_secs(20);
    let (addresses, token) = (addresses.to_vec(), "a secret of the run".into());
    RankOptions { addresses, rank, token, joining, patience: joining, ..RankOptions::default() }
}

/// Runs each rank in a thread of its own.
fn on_ranks<T: Send>(ranks: usize, run: impl Fn(usize, Vec<Address>) -> T + Sync) -> Vec<T> {
    let addresses = addresses(ranks);
    std::thread::scope(|scope| {
        let begin = |rank| {
            let (run, addresses) = (&run, addresses.clone());
            scope.spawn(move || run(rank, addresses))
        };
        let threads: Vec<_> = (0..ranks).map(begin).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    })
}

/// Exchanges messages that are empty, short and of several parts.
fn exchanged(mut ranks: impl Transport) -> Vec<Vec<Vec<u8>>> {
    let message = |from: usize, to: usize| match (from + 2 * to) % 3 {
        0 => Vec::new(),
        1 => vec![from as u8; 5 + to],
        _ => (0..2 * MAX_PART + 7).map(|at| (at * (from + 3) + to) as u8).collect(),
    };
    let (own, count) = (ranks.rank(), ranks.ranks());
    let mut received = Vec::new();
    for _ in 0..2 {
        received.push(ranks.exchange((0..count).map(|to| message(own, to)).collect()).unwrap());
        received.push(ranks.gather(vec![own as u8; 3 * own]).unwrap());
    }
    received
}

#[test]
fn messages_over_tcp_are_those_of_one_process() {
    let expected: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = InProcess::new(3).into_iter().map(|ranks| scope.spawn(|| exchanged(ranks))).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let found = on_ranks(3, |rank, addresses| exchanged(RpcRanks::join(&options(&addresses, rank)).unwrap()));
    assert!(found == expected);
    let alone = on_ranks(1, |rank, addresses| exchanged(RpcRanks::join(&options(&addresses, rank)).unwrap()));
    assert_eq!(alone[0][1], [Vec::<u8>::new()]);
}

/// Where a fluid is after its last frame, of all ranks where there is a transport.
fn simulated(transport: Option<Box<dyn Transport>>) -> Result<Option<Checkpoint>> {
    let context = Context::serial();
    let making = Making { format: "rlvfluid".into(), parts: 1, device: None };
    let mut simulation =
        Simulation::begin(&context, Description::parse(DAM)?, &in_folder(std::path::Path::new("")), making)?;
    transport.map_or(Ok(()), |transport| simulation.distribute(transport))?;
    while simulation.step() < simulation.last() {
        simulation.advance(&context, |_| Ok(()))?;
    }
    simulation.gather()
}

#[test]
fn domains_over_tcp_end_in_the_bits_of_one_fluid() {
    let expected = simulated(None).unwrap().unwrap();
    for count in [2, 3] {
        let states = on_ranks(count, |rank, addresses| {
            simulated(Some(Box::new(RpcRanks::join(&options(&addresses, rank)).unwrap()))).unwrap()
        });
        assert!(states[0].as_ref() == Some(&expected), "{count} ranks");
        assert!(states[1..].iter().all(Option::is_none));
    }
}

#[test]
fn a_rank_that_ends_is_an_error_on_the_others() {
    let errors = on_ranks(3, |rank, addresses| {
        let mut ranks = RpcRanks::join(&options(&addresses, rank)).unwrap();
        ranks.gather(vec![1]).unwrap();
        if rank == 1 { None } else { ranks.gather(vec![2]).err() }
    });
    for rank in [0, 2] {
        let error = errors[rank].as_ref().unwrap().to_string();
        assert!(error.contains("rank 1") && error.contains("has ended"), "{error}");
    }
}

#[test]
fn strangers_hold_up_no_rank() {
    let addresses = addresses(2);
    let ranks = std::thread::scope(|scope| {
        let first = scope.spawn(|| RpcRanks::join(&options(&addresses, 0)));
        let Address::Tcp { port, .. } = addresses[0] else { panic!("TCP") };
        let mut strangers = Vec::new();
        let hello = request(1, "hello", &Nothing {}).unwrap();
        // Nothing, no MessagePack, another method, a message that is too long, and one that is cut.
        let bytes: [&[u8]; 5] = [b"", b"GET / HTTP/1.1\r\n\r\n", &hello, &[0xc6, 0xff, 0xff, 0xff, 0xff], &hello[..3]];
        for bytes in bytes {
            let mut stream = loop {
                match TcpStream::connect(("127.0.0.1", port)) {
                    Ok(stream) => break stream,
                    Err(_) => std::thread::sleep(Duration::from_millis(2)),
                }
            };
            stream.write_all(bytes).unwrap();
            strangers.push(stream);
        }
        let other = RankOptions { token: "another".into(), ..options(&addresses, 1) };
        let refused = RpcRanks::join(&other).err().unwrap().to_string();
        assert!(refused.contains("different tokens"), "{refused}");
        let more = RankOptions { addresses: [addresses.as_slice(), &addresses].concat(), ..options(&addresses, 1) };
        let refused = join_as_last(&more).to_string();
        assert!(refused.contains("same --ranks"), "{refused}");
        let second = RpcRanks::join(&options(&addresses, 1));
        [first.join().unwrap().unwrap(), second.unwrap()]
    });
    let [mut first, mut second] = ranks;
    std::thread::scope(|scope| {
        let sent = scope.spawn(|| second.gather(vec![7]).unwrap());
        assert_eq!(first.gather(vec![6]).unwrap(), [[6], [7]]);
        assert_eq!(sent.join().unwrap(), [[6], [7]]);
    });
}

/// Why a rank is refused that has a list of other ranks.
fn join_as_last(options: &RankOptions) -> Error {
    RpcRanks::join(&RankOptions { rank: options.addresses.len() - 1, ..options.clone() }).err().unwrap()
}

#[test]
fn ranks_that_cannot_be_are_refused() {
    let addresses = addresses(2);
    let short = RankOptions { joining: Duration::from_millis(50), ..options(&addresses, 0) };
    let refused = |options: &RankOptions, why: &str| {
        let error = RpcRanks::join(options).err().unwrap().to_string();
        assert!(error.contains(why), "{why}: {error}");
    };
    refused(&short, "rank 1 at 127.0.0.1");
    refused(&RankOptions { rank: 1, ..short.clone() }, "rank 0 at 127.0.0.1");
    refused(&RankOptions { rank: 2, ..short.clone() }, "not among 2");
    let named = |text: &str| vec![text.parse().unwrap(), addresses[1].clone()];
    refused(&RankOptions { addresses: named("192.0.2.1:7351"), ..short.clone() }, "--allow-remote");
    refused(&RankOptions { addresses: named("unix:/none"), ..short.clone() }, "host:port");
    refused(&RankOptions { addresses: named("tls://127.0.0.1:7351"), ..short }, "host:port");
}

#[test]
fn messages_that_are_none_of_a_rank_are_errors() {
    #[derive(serde::Serialize)]
    struct Part {
        following: u64,
        #[serde(with = "serde_bytes")]
        data: Vec<u8>,
    }
    #[derive(serde::Serialize)]
    struct Join {
        release: &'static str,
        rank: u64,
        ranks: u64,
    }
    let part = |following, size| notification("domain.part", &Part { following, data: vec![0; size] }).unwrap();
    let bad = [
        (b"no MessagePack".to_vec(), "MessagePack"),
        (notification("domain.whole", &Nothing {}).unwrap(), "domain.part"),
        (part(0, 2000), "limit"),
        (part(u64::MAX, 1), "limit"),
        (part(3, 0), "empty"),
        (part(1, 1), "has ended"),
    ];
    for (bytes, why) in bad {
        let addresses = addresses(2);
        let options = RankOptions { token: String::new(), limit: 1000, ..options(&addresses, 0) };
        let error = std::thread::scope(|scope| {
            let first = scope.spawn(|| RpcRanks::join(&options).unwrap().gather(Vec::new()).unwrap_err());
            let Address::Tcp { port, .. } = addresses[0] else { panic!("TCP") };
            let mut stream = loop {
                match TcpStream::connect(("127.0.0.1", port)) {
                    Ok(stream) => break stream,
                    Err(_) => std::thread::sleep(Duration::from_millis(2)),
                }
            };
            let join = Join { release: env!("CARGO_PKG_VERSION"), rank: 1, ranks: 2 };
            stream.write_all(&request(1, "domain.join", &join).unwrap()).unwrap();
            stream.write_all(&bytes).unwrap();
            let _ = stream.shutdown(std::net::Shutdown::Write);
            first.join().unwrap().to_string()
        });
        assert!(error.contains(why), "{why}: {error}");
    }
}
