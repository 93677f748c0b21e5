//! What devices compute, against the same on the processor, and what they answer when something is wrong.

use relievo_core::ErrorKind;
use relievo_gpu::{AdapterChoice, Buffer, Compaction, Device, DeviceOptions, Scan, Sort, adapters, groups};
use relievo_testing::{Random, device};

/// Lengths around the ends of workgroups and blocks; the last needs two rounds of the kernel over the blocks' sums.
const LENGTHS: [usize; 9] = [0, 1, 255, 256, 257, 2047, 2048, 2049, 300_000];
const LONG: usize = 2048 * 2048 + 2049;

fn numbers(seed: u64, count: usize) -> Vec<u32> {
    let mut random = Random(seed);
    (0..count).map(|_| (random.below(1 << 16) << 16 | random.below(1 << 16)) as u32).collect()
}

fn exclusive(items: &[u32]) -> Vec<u32> {
    let mut sum = 0_u32;
    items
        .iter()
        .map(|item| {
            let before = sum;
            sum = sum.wrapping_add(*item);
            before
        })
        .collect()
}

#[test]
fn prefix_sums_are_those_of_the_processor() {
    let Some(device) = device() else { return };
    for count in LENGTHS.into_iter().chain([LONG]) {
        let items = numbers(count as u64, count);
        let buffer = Buffer::of(&device, "items", &items).expect("a buffer");
        let lengths = Buffer::of(&device, "lengths", &[0, count as u32 / 2]).expect("a buffer");
        let scan = Scan::new(&device, &buffer, &lengths).expect("a scan");
        let mut frame = device.frame().expect("a frame");
        scan.run(&mut frame.pass("scan"), count as u32).expect("a scan");
        let result = frame.read(&buffer, 0..count).expect("a copy");
        let times = frame.submit().expect("a submission").wait().expect("an end");
        assert!(!device.is_timed() || times.len() == 1 && times[0].name == "scan", "{times:?}");
        assert!(result.get(&device).expect("items") == exclusive(&items), "{count} items");

        // As many as a buffer says; the others stay.
        buffer.write(&device, 0, &items).expect("a write");
        let mut frame = device.frame().expect("a frame");
        scan.run_indirect(&mut frame.pass("scan"), 1).expect("a scan");
        let result = frame.read(&buffer, 0..count).expect("a copy");
        let _ = frame.submit().expect("a submission");
        let mut expected = exclusive(&items[..count / 2]);
        expected.extend(&items[count / 2..]);
        assert!(result.get(&device).expect("items") == expected, "half of {count} items");
    }
}

#[test]
fn compaction_lists_the_items_of_every_class_in_order() {
    let Some(device) = device() else { return };
    for count in LENGTHS {
        let masks: Vec<_> = numbers(7 + count as u64, count).iter().map(|it| it & (it >> 5)).collect();
        let buffer = Buffer::of(&device, "masks", &masks).expect("a buffer");
        let compaction = Compaction::new(&device, &buffer, 3).expect("a compaction");
        let mut frame = device.frame().expect("a frame");
        compaction.run(&mut frame.pass("compaction"), count as u32).expect("a compaction");
        let lists = frame.read(compaction.lists(), 0..3 * count).expect("a copy");
        let counts = frame.read(compaction.counts(), 0..12).expect("a copy");
        let _ = frame.submit().expect("a submission");
        let (lists, counts) = (lists.get(&device).expect("lists"), counts.get(&device).expect("counts"));
        for class in 0..3 {
            let expected: Vec<_> = (0..count as u32).filter(|&it| masks[it as usize] >> class & 1 == 1).collect();
            let listed = &lists[class * count..][..expected.len()];
            assert_eq!(listed, expected, "class {class} of {count} items");
            let number = expected.len() as u32;
            assert_eq!(counts[4 * class..][..4], [number, number.div_ceil(256), u32::from(number > 0), 1]);
        }
    }
}

#[test]
fn sorting_is_stable_and_ends_where_it_began() {
    let Some(device) = device() else { return };
    for (count, bits) in LENGTHS.into_iter().map(|count| (count, 32)).chain([(100_000, 9), (5000, 1)]) {
        let keys: Vec<_> = numbers(11, count).iter().map(|key| key & (u32::MAX >> (32 - bits))).collect();
        let values: Vec<_> = (0..count as u32).collect();
        let on_device = [&keys, &values].map(|items| Buffer::of(&device, "sorted", items).expect("a buffer"));
        let sort = Sort::new(&device, &on_device[0], &on_device[1]).expect("a sort");
        let mut frame = device.frame().expect("a frame");
        sort.run(&mut frame.pass("sort"), count as u32, bits).expect("a sort");
        let sorted = [0, 1].map(|index| frame.read(&on_device[index], 0..count).expect("a copy"));
        let _ = frame.submit().expect("a submission");
        let [sorted_keys, sorted_values] = sorted.map(|items| items.get(&device).expect("items"));
        let mut expected = values;
        expected.sort_by_key(|&index| keys[index as usize]);
        assert!(sorted_values == expected, "{count} keys of {bits} bits");
        assert!(expected.iter().map(|&index| keys[index as usize]).eq(sorted_keys), "{count} keys of {bits} bits");
    }
}

#[test]
fn a_dispatch_of_many_groups_has_each_of_them() {
    assert_eq!(groups(0), [0, 1, 1]);
    for count in [1, 32_768, 32_769, 65_536, 1 << 30] {
        let [x, y, z] = groups(count);
        assert!(x <= 65_535 && y <= 65_535 && z == 1);
        assert!(u64::from(x) * u64::from(y) >= u64::from(count) && x * (y - 1) < count);
    }
}

#[test]
fn a_device_that_is_not_there_is_an_error_with_those_that_are() {
    let open = |adapter| Device::open(&DeviceOptions { adapter, ..Default::default() });
    let error = open(AdapterChoice::Named("no such card".into())).expect_err("no such card");
    assert_eq!(error.kind, ErrorKind::NotFound);
    for adapter in adapters() {
        assert!(error.remedy.contains(&adapter.name), "{error}");
        let device = open(AdapterChoice::Named(adapter.name.to_uppercase())).expect("it is there");
        assert_eq!(device.summary().name, adapter.name);
    }
}

#[test]
fn memory_is_counted_and_limited() {
    let Some(device) = device() else { return };
    let options = DeviceOptions {
        adapter: AdapterChoice::Named(device.summary().name.clone()),
        memory_limit: 4096,
        ..Default::default()
    };
    let device = Device::open(&options).expect("a device");
    let small = Buffer::<u16>::new(&device, "small", 3).expect("a buffer");
    assert_eq!(device.memory(), 8, "three halves are two words");
    assert_eq!(Buffer::<u32>::new(&device, "large", 1024).expect_err("over the limit").kind, ErrorKind::Memory);
    let huge = Buffer::<[u32; 4]>::new(&device, "huge", usize::MAX / 8).expect_err("over every limit");
    assert_eq!(huge.kind, ErrorKind::Memory);
    assert!(huge.to_string().contains("`huge`"), "{huge}");
    drop(small);
    assert_eq!(device.memory(), 0);
    device.check().expect("a refused buffer is no fault of the device");
}

#[test]
fn odd_numbers_of_halves_come_back() {
    let Some(device) = device() else { return };
    let halves: Vec<u16> = (1..8).collect();
    let buffer = Buffer::of(&device, "halves", &halves).expect("a buffer");
    buffer.write(&device, 4, &[50, 60, 70]).expect("the end");
    assert!(buffer.write(&device, 1, &[1, 2]).is_err(), "no whole word");
    assert!(buffer.write(&device, 4, &[1, 2, 3, 4]).is_err(), "beyond the end");
    let mut frame = device.frame().expect("a frame");
    let copy = frame.read(&buffer, 0..7).expect("a copy");
    assert!(frame.read(&buffer, 6..8).is_err(), "beyond the end");
    let _ = frame.submit().expect("a submission");
    assert_eq!(copy.get(&device).expect("halves"), [1, 2, 3, 4, 50, 60, 70]);
}

#[test]
fn readbacks_on_their_way_together_keep_apart() {
    let Some(device) = device() else { return };
    let buffer = Buffer::of(&device, "items", &numbers(3, 4096)).expect("a buffer");
    // Each round finds the buffers of the round before, of fewer or more bytes.
    for round in 0..6_u32 {
        let count = [4096, 10, 1000][round as usize % 3];
        buffer.write(&device, 0, &numbers(u64::from(round), 4096)).expect("a write");
        let mut frame = device.frame().expect("a frame");
        drop(frame.pass("nothing"));
        let whole = frame.read(&buffer, 0..count).expect("a copy");
        let end = frame.read(&buffer, 4096 - count..4096).expect("a copy");
        let unread = frame.read(&buffer, 0..count).expect("a copy");
        drop(frame.submit().expect("a submission"));
        let expected = numbers(u64::from(round), 4096);
        assert!(end.get(&device).expect("items") == expected[4096 - count..], "round {round}");
        assert!(whole.get(&device).expect("items") == expected[..count], "round {round}");
        drop(unread);
    }
}

#[test]
fn a_lost_device_is_an_error_of_every_later_call() {
    let Some(device) = device() else { return };
    let buffer = Buffer::of(&device, "items", &[1_u32, 2, 3]).expect("a buffer");
    let scan = Scan::new(&device, &buffer, &buffer).expect("a scan");
    let mut frame = device.frame().expect("a frame");
    scan.run(&mut frame.pass("scan"), 3).expect("a scan");
    let copy = frame.read(&buffer, 0..3).expect("a copy");
    device.abandon();
    let errors = [
        frame.submit().map(drop).expect_err("a submission"),
        copy.get(&device).map(drop).expect_err("a copy"),
        device.check().expect_err("a check"),
        device.frame().map(drop).expect_err("a frame"),
        Buffer::<u32>::new(&device, "items", 3).map(drop).expect_err("a buffer"),
    ];
    for error in errors {
        assert_eq!(error.kind, ErrorKind::Device, "{error}");
        assert!(error.remedy.contains("`cpu`"), "{error}");
    }
}
