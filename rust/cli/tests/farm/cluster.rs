//! A cluster of Slurm with this machine as its only node, on ports and with keys of its own.

use std::fmt::Write;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Seconds until a daemon answers, and until jobs are done, at most.
const STARTED: Duration = Duration::from_secs(30);
const DONE: Duration = Duration::from_secs(240);

pub struct Cluster {
    folder: tempfile::TempDir,
    daemons: Vec<Child>,
}

impl Cluster {
    /// Starts the daemons; `None` where one is not installed.
    pub fn start() -> Option<Self> {
        let programs = ["munged", "slurmctld", "slurmd"].map(|name| PathBuf::from("/usr/sbin").join(name));
        if !programs.iter().all(|program| program.exists()) {
            return None;
        }
        let [munged, controller, node] = programs;
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("munge.key"), std::array::from_fn::<u8, 128, _>(|at| at as u8)).unwrap();
        // Munge takes no key that others may read.
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(path("munge.key"), std::fs::Permissions::from_mode(0o400)).unwrap();
        ["state", "spool"].iter().for_each(|name| std::fs::create_dir(path(name)).unwrap());
        let listeners: [TcpListener; 2] = std::array::from_fn(|_| TcpListener::bind("127.0.0.1:0").unwrap());
        let ports = listeners.map(|listener| listener.local_addr().unwrap().port());
        let mut cluster = Self { folder, daemons: Vec::new() };
        std::fs::write(cluster.configuration(), cluster.settings(ports)).unwrap();
        let file = |name: &str| cluster.folder.path().join(name);
        let mut munge = Command::new(munged);
        munge.args(["--foreground", "--force"]);
        for (option, name) in [
            ("--key-file", "munge.key"),
            ("--socket", "munge.socket"),
            ("--pid-file", "munged.pid"),
            ("--log-file", "munged.log"),
            ("--seed-file", "munged.seed"),
        ] {
            munge.arg(option).arg(file(name));
        }
        let daemons = [controller, node].map(|program| {
            let mut daemon = Command::new(program);
            daemon.arg("-D").arg("-f").arg(cluster.configuration());
            daemon
        });
        cluster.daemons.push(quiet(&mut munge).spawn().unwrap());
        cluster.until(STARTED, "munged", || cluster.folder.path().join("munge.socket").exists());
        for mut daemon in daemons {
            cluster.daemons.push(quiet(&mut daemon).spawn().unwrap());
        }
        cluster.until(STARTED, "the node", || cluster.said("sinfo", &["--noheader", "--format=%t"]).trim() == "idle");
        Some(cluster)
    }

    /// Has a command use this cluster.
    pub fn command<'a>(&self, command: &'a mut Command) -> &'a mut Command {
        command.env("SLURM_CONF", self.configuration())
    }

    /// Waits until no job is left.
    pub fn wait(&self) {
        self.until(DONE, "jobs", || self.said("squeue", &["--noheader"]).trim().is_empty());
    }

    /// What the daemons say.
    pub fn log(&self) -> String {
        ["slurmctld.log", "slurmd.log"]
            .iter()
            .map(|name| std::fs::read_to_string(self.folder.path().join(name)).unwrap_or_default())
            .collect()
    }

    fn configuration(&self) -> PathBuf {
        self.folder.path().join("slurm.conf")
    }

    fn settings(&self, [controller, node]: [u16; 2]) -> String {
        let host = std::fs::read_to_string("/proc/sys/kernel/hostname").unwrap();
        let host = host.trim().split('.').next().unwrap();
        let folder = self.folder.path().display();
        let mut text = format!(
            "ClusterName=relievo\nSlurmctldHost={host}(127.0.0.1)\nSlurmctldPort={controller}\nSlurmdPort={node}\n\
             AuthType=auth/munge\nAuthInfo=socket={folder}/munge.socket\nCredType=cred/munge\n\
             StateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\nReturnToService=2\n\
             JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n\
             SchedulerParameters=sched_interval=1,sched_min_interval=0,bf_interval=1\nMinJobAge=10\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\n\
             NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN\n\
             PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP\n"
        );
        for daemon in ["Slurmctld", "Slurmd"] {
            let name = daemon.to_lowercase();
            writeln!(text, "{daemon}PidFile={folder}/{name}.pid\n{daemon}LogFile={folder}/{name}.log").unwrap();
        }
        let user = Command::new("id").arg("-un").output().unwrap();
        let user = String::from_utf8(user.stdout).unwrap();
        writeln!(text, "SlurmUser={0}\nSlurmdUser={0}", user.trim()).unwrap();
        text
    }

    fn said(&self, program: &str, arguments: &[&str]) -> String {
        let said = self.command(Command::new(program).args(arguments)).output().unwrap();
        match said.status.success() {
            true => String::from_utf8(said.stdout).unwrap(),
            false => String::from_utf8_lossy(&said.stderr).into_owned(),
        }
    }

    fn until(&self, most: Duration, what: &str, is_there: impl Fn() -> bool) {
        let begin = Instant::now();
        while !is_there() {
            assert!(begin.elapsed() < most, "waiting for {what}: {}", self.log());
            std::thread::sleep(Duration::from_millis(200));
        }
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            // A daemon that has ended is none to stop.
            let _ = daemon.kill();
            let _ = daemon.wait();
        }
    }
}

fn quiet(command: &mut Command) -> &mut Command {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null())
}
