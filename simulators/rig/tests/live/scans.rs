//! Scans without faults: when they begin, what arrives, what holds them back, how they end.

use std::time::Duration;

use asphera_rig::{Plan, Scene, Speed, Trigger};
use tokio::time::{sleep, timeout};

use crate::host::{
    PATIENCE, Telegram, address, arm_probe, arm_stage, aside, cycle, disarm, start, telegram,
};

fn scene(points: u64) -> Scene {
    Scene::built_in("asphere").unwrap().with_points(points).with_speed(Speed::Max)
}

fn expected(k: usize, trigger: &Trigger) -> (Telegram, (u8, Vec<i32>)) {
    let probe = Telegram {
        exposure: (k % 65_536) as u16,
        encoder: trigger.stop.rotary_counts,
        distance_um: trigger.distance_um,
    };
    (probe, ((k % 240 + 1) as u8, trigger.stop.stage_steps[..1].to_vec()))
}

/// More points than an exposure count has numbers, not to speak of the SYNC counter.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_scan_begins_when_all_is_armed_and_arrives_whole_in_order() {
    let scene = scene(70_000);
    let (_dir, rig) = start(scene.clone()).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let mut probe = aside(|| arm_probe(probe)).await;
    assert!(timeout(Duration::from_millis(50), rig.finished()).await.is_err());
    assert_eq!(rig.progress(), 0, "the stage is not armed");
    let mut stage = aside(|| arm_stage(stage, &[5])).await;

    let telegrams =
        aside(move || (0..70_000).map_while(|_| telegram(&mut probe)).collect::<Vec<_>>());
    let cycles = aside(move || (0..70_000).map_while(|_| cycle(&mut stage, 1)).collect::<Vec<_>>());
    let (telegrams, cycles) = tokio::join!(telegrams, cycles);
    timeout(PATIENCE, rig.finished()).await.unwrap();
    assert_eq!(rig.progress(), 70_000);

    let plan = Plan::new(&scene).unwrap();
    assert_eq!(plan.truth(), rig.truth());
    assert_eq!((telegrams.len(), cycles.len()), (70_000, 70_000));
    for (k, trigger) in plan.triggers().iter().enumerate() {
        let (probe, stage) = expected(k, trigger);
        assert_eq!((telegrams[k], &cycles[k]), (probe, &stage), "trigger {k}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn hosts_that_do_not_read_hold_the_scan_back_within_bounds_and_lose_nothing() {
    let scene = scene(40_000);
    let (_dir, rig) = start(scene.clone()).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let mut probe = aside(|| arm_probe(probe)).await;
    let mut stage = aside(|| arm_stage(stage, &[5])).await;
    let mut before = u64::MAX;
    while before != rig.progress() {
        before = rig.progress();
        sleep(Duration::from_millis(300)).await;
    }
    // The system holds some 12 KiB of a line, 700 telegrams, and the bench no more than its queues.
    assert!((1..2_000).contains(&before), "{before} triggers with nobody reading");
    let telegrams =
        aside(move || (0..40_000).map_while(|_| telegram(&mut probe)).collect::<Vec<_>>());
    let cycles = aside(move || (0..40_000).map_while(|_| cycle(&mut stage, 1)).collect::<Vec<_>>());
    let (telegrams, cycles) = tokio::join!(telegrams, cycles);
    for (k, trigger) in Plan::new(&scene).unwrap().triggers().iter().enumerate() {
        let (probe, stage) = expected(k, trigger);
        assert_eq!((telegrams[k], &cycles[k]), (probe, &stage), "trigger {k}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn triggers_come_at_the_rate_of_the_scene() {
    let scene = Scene::built_in("asphere").unwrap().with_points(2_000);
    let (_dir, rig) = start(scene.with_speed(Speed::Times(0.5))).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let mut probe = aside(|| arm_probe(probe)).await;
    let mut stage = aside(|| arm_stage(stage, &[5])).await;
    let begin = tokio::time::Instant::now();
    let telegrams = aside(move || (0..2_000).map_while(|_| telegram(&mut probe)).count());
    let cycles = aside(move || (0..2_000).map_while(|_| cycle(&mut stage, 1)).count());
    assert_eq!(tokio::join!(telegrams, cycles), (2_000, 2_000));
    // 2000 triggers at 2000 Hz; a busy computer may only make it longer.
    assert!(begin.elapsed() >= Duration::from_millis(950), "{:?}", begin.elapsed());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_raster_has_both_axes_on_one_bus() {
    let scene = Scene::built_in("sphere").unwrap().with_points(900).with_speed(Speed::Max);
    let (_dir, rig) = start(scene.clone()).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let mut probe = aside(|| arm_probe(probe)).await;
    let mut stage = aside(|| arm_stage(stage, &[5, 6])).await;
    let cycles = aside(move || (0..900).map_while(|_| cycle(&mut stage, 2)).collect::<Vec<_>>());
    let telegrams = aside(move || (0..900).map_while(|_| telegram(&mut probe)).collect::<Vec<_>>());
    let (cycles, telegrams) = tokio::join!(cycles, telegrams);
    for (k, trigger) in Plan::new(&scene).unwrap().triggers().iter().enumerate() {
        assert_eq!(cycles[k].1, trigger.stop.stage_steps);
        assert_eq!(telegrams[k].distance_um, trigger.distance_um);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_host_that_disarms_and_arms_again_gets_the_scan_again() {
    let scene = scene(50);
    let (_dir, rig) = start(scene.clone()).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let triggers = Plan::new(&scene).unwrap();
    for _ in 0..3 {
        let (probe, stage) = (probe.clone(), stage.clone());
        let hosts = aside(move || (arm_probe(probe), arm_stage(stage, &[5])));
        let (mut probe, mut stage) = hosts.await;
        let read = aside(move || {
            let telegrams: Vec<_> = (0..50).map_while(|_| telegram(&mut probe)).collect();
            let cycles: Vec<_> = (0..50).map_while(|_| cycle(&mut stage, 1)).collect();
            disarm(&mut probe, &mut stage);
            (telegrams, cycles)
        });
        let (telegrams, cycles) = read.await;
        for (k, trigger) in triggers.triggers().iter().enumerate() {
            let (probe, stage) = expected(k, trigger);
            assert_eq!((telegrams[k], &cycles[k]), (probe, &stage), "trigger {k}");
        }
        sleep(AWAY).await;
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_scan_whose_host_disarms_all_is_given_up_and_the_next_begins_at_its_start() {
    let scene = Scene::built_in("asphere").unwrap().with_points(100_000);
    let (_dir, rig) = start(scene).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let again = (probe.clone(), stage.clone());
    let (mut probe, mut stage) = aside(|| (arm_probe(probe), arm_stage(stage, &[5]))).await;
    aside(move || {
        assert_eq!((0..100).map_while(|_| telegram(&mut probe)).count(), 100);
        disarm(&mut probe, &mut stage);
    })
    .await;
    sleep(AWAY).await;
    let given_up = rig.progress();
    assert!((100..5_000).contains(&given_up), "{given_up}");
    sleep(AWAY).await;
    assert_eq!(rig.progress(), given_up, "nobody wants more of it");
    let (mut probe, mut stage) = aside(|| (arm_probe(again.0), arm_stage(again.1, &[5]))).await;
    let first = aside(move || (telegram(&mut probe).unwrap().exposure, cycle(&mut stage, 1)));
    let (exposure, cycle) = first.await;
    assert_eq!((exposure, cycle.unwrap().0), (0, 1));
}

/// Longer than it takes to see that a host has left.
const AWAY: Duration = Duration::from_millis(500);

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn after_the_scan_devices_answer_until_the_rig_is_dropped() {
    let (dir, rig) = start(scene(50)).await;
    let (probe, stage) = (address(&rig, "probe"), address(&rig, "stage"));
    let mut probe_host = aside(|| arm_probe(probe)).await;
    let mut stage_host = aside(|| arm_stage(stage, &[5])).await;
    timeout(PATIENCE, rig.finished()).await.unwrap();
    let (mut probe, mut stage) = aside(move || {
        assert_eq!((0..50).map_while(|_| telegram(&mut probe_host)).count(), 50);
        assert_eq!((0..50).map_while(|_| cycle(&mut stage_host, 1)).count(), 50);
        probe_host.say("$SCA ?\r");
        assert_eq!(probe_host.until(b"ready\r\n").unwrap(), b"$SCA ? 6000ready\r\n");
        stage_host.say("V\r");
        assert_eq!(stage_host.until(b"\r").unwrap(), b"V1013\r");
        (probe_host, stage_host)
    })
    .await;
    drop(rig);
    let ports = dir.path().join("ports");
    assert!(!ports.join("probe").is_symlink() && !ports.join("stage").is_symlink());
    assert!(aside(move || telegram(&mut probe).is_none() && cycle(&mut stage, 1).is_none()).await);
}
