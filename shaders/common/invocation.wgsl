// Which invocation of a dispatch over workgroups of one dimension runs.

/// An invocation.
struct Invocation {
    /// The workgroup, and how many there are along each axis.
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    /// Its number in the workgroup.
    @builtin(local_invocation_index) local: u32,
}
