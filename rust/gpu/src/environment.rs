//! What drivers print on the standard error of a program.

/// Keeps Mesa's layer for the choice of devices from looking for a desktop where there is none: it prints an error about
/// `XDG_RUNTIME_DIR` for every instance. For programs, at the start of `main`: it sets a variable of the environment, and
/// does nothing in a process that has other threads already.
pub fn quiet_drivers() {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    if set("XDG_RUNTIME_DIR") || set("WAYLAND_DISPLAY") || set("NODEVICE_SELECT") {
        return;
    }
    let alone = std::fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1);
    if alone {
        // SAFETY: no other thread reads or writes the environment, since there is none.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
}
