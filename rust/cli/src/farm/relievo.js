// The job type of Relievo for Flamenco 3. Put this file into the folder `scripts` beside the Manager.

const JOB_TYPE = {
    label: "Relievo Fluid",
    settings: [
        {
            key: "plan",
            type: "string",
            required: true,
            visible: "web",
            description: "The stages of the job in JSON, as `relievo farm submit` writes them",
        },
    ],
};

function compileJob(job) {
    const plan = JSON.parse(job.settings.plan);
    const tasks = {};
    for (const stage of plan.stages) {
        tasks[stage.name] = [];
        const chunk = stage.parallel ? plan.chunk : plan.last - plan.first + 1;
        for (let first = plan.first; first <= plan.last; first += chunk) {
            const frames = `${first}..${Math.min(first + chunk - 1, plan.last)}`;
            const task = author.Task(stage.parallel ? `${stage.name} ${frames}` : stage.name, "misc");
            task.addCommand(author.Command("exec", {
                exe: stage.command[0],
                args: stage.command.slice(1).map(word => word === "{frames}" ? frames : word),
            }));
            for (const needed of stage.after) {
                tasks[needed].forEach(before => task.addDependency(before));
            }
            job.addTask(task);
            tasks[stage.name].push(task);
        }
    }
}
