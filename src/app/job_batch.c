/* Batch file -> solutions and pictures: which jobs run when, and what became of them. */
#include "app/batch_work.h"
#include "app/manifest.h"

#include <errno.h>
#include <fcntl.h>
#include <hprad/batch.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

enum { MAX_JOBS = 1024 };

void hpr_batch_options_init(hpr_batch_options *options)
{
    *options = (hpr_batch_options){.jobs = 1, .shard = 1, .shard_count = 1};
}

typedef enum task_state { WAITS, RUNS, DONE, FAILED } task_state;

typedef struct task {
    hpr_batch_task_kind kind;
    size_t index; /* of the solution or the group */
    size_t needs; /* the task that must be done before; SIZE_MAX: none */
    bool alone;   /* it wanted more memory than its share: nothing else may run beside it */
    task_state state;
    pid_t process;
    int pipe;
    bool ended; /* its last message has come */
} task;

typedef struct batch {
    hpr_context *context;
    const hpr_batch_plan *plan;
    const hpr_batch_options *options;
    hpr_batch_result *result;
    double memory_bytes;
    size_t count, running;
    bool exclusive; /* what runs wants to be alone */
    bool stopping;  /* nothing more is said */
    task *task;     /* [count] a solution before its groups */
} batch;

static void say(const batch *b, hpr_batch_event_kind kind, const char *path, const char *text, bool reused)
{
    const hpr_batch_event event = {.kind = kind, .path = path, .text = text, .reused = reused};
    if (b->options->said && !b->stopping)
        b->options->said(b->options->user, &event);
}

static const char *name_of(const batch *b, const task *t)
{
    if (t->kind == HPR_BATCH_SOLVE)
        return b->plan->solution[t->index].path;
    const hpr_batch_group *group = b->plan->group + t->index;
    return group->pictures.count ? group->pictures.files[0].exr : group->pattern;
}

/* The tasks of this shard. Groups are dealt out in turn; a solution goes with every group that needs it. */
static hpr_status list_tasks(batch *b)
{
    const hpr_batch_plan *plan = b->plan;
    size_t shard = (size_t)b->options->shard - 1, shards = (size_t)b->options->shard_count;
    hpr_status status = hpr_allocate_into(b->context, &b->task, plan->solution_count + plan->group_count,
                                          sizeof *b->task, "the jobs of a batch");
    size_t solved = SIZE_MAX, task_of_it = 0;
    for (size_t g = 0; g < plan->group_count && status == HPR_OK; g++) {
        if (g % shards != shard)
            continue;
        const hpr_batch_group *group = plan->group + g;
        if (group->solution != solved) {
            solved = group->solution;
            task_of_it = b->count++;
            b->task[task_of_it] = (task){.kind = HPR_BATCH_SOLVE, .index = solved, .needs = SIZE_MAX};
        }
        b->task[b->count++] = (task){.kind = HPR_BATCH_RENDER, .index = g, .needs = task_of_it};
    }
    return status;
}

/* Puts a job back that ran out of its share of the memory, to run alone; false if it had all of it. */
static bool try_alone(const batch *b, task *t)
{
    if (t->alone || b->options->jobs == 1)
        return false;
    t->alone = true;
    t->state = WAITS;
    return true;
}

static void fail_task(batch *b, task *t, const char *why)
{
    t->state = FAILED;
    b->result->failed++;
    say(b, HPR_BATCH_FAILED, name_of(b, t), why, false);
}

/* In the new process. */
static void run_task(const batch *b, const task *t, int pipe, pid_t parent)
{
    const hpr_batch_means means = {
        .threads = t->alone ? hpr_context_threads(b->context)
                            : (hpr_context_threads(b->context) + b->options->jobs - 1) / b->options->jobs,
        .memory_bytes = t->alone ? b->memory_bytes : b->memory_bytes / b->options->jobs,
        .pipe = pipe};
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* a batch that is killed takes its jobs along */
    if (getppid() == parent)
        hpr_batch_work(b->plan, t->kind, t->index, &means);
    _exit(0); /* not exit: what the command has buffered is not ours */
}

static void start_task(batch *b, task *t)
{
    int ends[2];
    pid_t parent = getpid();
    if (pipe2(ends, O_CLOEXEC) != 0) {
        fail_task(b, t, strerror(errno));
        return;
    }
    pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        run_task(b, t, ends[1], parent);
    }
    close(ends[1]);
    if (process < 0) {
        close(ends[0]);
        fail_task(b, t, strerror(errno));
        return;
    }
    t->process = process;
    t->pipe = ends[0];
    t->state = RUNS;
    t->ended = false;
    b->running++;
    b->exclusive = t->alone;
}

/* Whether a waiting task may begin; one whose solution failed is left out. */
static bool is_ready(batch *b, task *t)
{
    if (t->state != WAITS || (t->alone && b->running))
        return false;
    if (t->needs == SIZE_MAX) {
        const char *trouble = b->plan->solution[t->index].trouble;
        if (trouble)
            fail_task(b, t, trouble);
        return !trouble;
    }
    if (b->task[t->needs].state == FAILED) {
        const hpr_batch_group *group = b->plan->group + t->index;
        size_t pictures = group->pictures.count ? group->pictures.count : 1;
        t->state = FAILED;
        b->result->left_out += pictures;
        say(b, HPR_BATCH_LEFT_OUT, name_of(b, t), "its solution failed", false);
    }
    return b->task[t->needs].state == DONE;
}

static void start_ready(batch *b)
{
    for (size_t i = 0; i < b->count && b->running < (size_t)b->options->jobs && !b->exclusive; i++) {
        if (is_ready(b, b->task + i))
            start_task(b, b->task + i);
    }
}

static void take_end(batch *b, task *t, const hpr_batch_message *message)
{
    t->ended = true;
    if (message->status == HPR_OK)
        t->state = DONE;
    else if (message->status != HPR_ERR_MEMORY || !try_alone(b, t))
        fail_task(b, t, message->text);
    if (t->kind == HPR_BATCH_SOLVE) {
        b->result->solved += message->made;
        b->result->solutions_reused += message->reused;
        b->result->missed += message->missed;
    } else {
        b->result->pictures += message->made;
        if (t->state != WAITS)
            b->result->pictures_reused += message->reused;
    }
}

/* Reads what has come; at the end of the pipe the process has ended. */
static void take_messages(batch *b, task *t)
{
    hpr_batch_message message;
    ssize_t got = read(t->pipe, &message, sizeof message);
    if (got < 0 && errno == EINTR)
        return;
    if (got == (ssize_t)sizeof message) {
        if (message.kind == HPR_BATCH_MESSAGE_WROTE)
            say(b, HPR_BATCH_WROTE, message.path, "", false);
        else if (message.kind == HPR_BATCH_MESSAGE_WARNING)
            hpr_warn(b->context, "%s", message.text);
        else
            take_end(b, t, &message);
        return;
    }
    int status = 0;
    while (waitpid(t->process, &status, 0) < 0 && errno == EINTR)
        continue;
    close(t->pipe);
    t->pipe = -1;
    b->running--;
    b->exclusive = false;                /* nothing ran beside it */
    if (!t->ended && !try_alone(b, t)) { /* some libraries end the process when there is no memory */
        char why[96];
        snprintf(why, sizeof why, "its process ended early (%s %d)",
                 WIFSIGNALED(status) ? "signal" : "exit code",
                 WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status));
        fail_task(b, t, why);
    }
}

/* Waits until some process has something to say. */
static void listen(batch *b)
{
    struct pollfd wait[MAX_JOBS];
    task *from[MAX_JOBS];
    nfds_t count = 0;
    for (size_t i = 0; i < b->count; i++) {
        if (b->task[i].process && b->task[i].pipe >= 0) {
            from[count] = b->task + i;
            wait[count++] = (struct pollfd){.fd = b->task[i].pipe, .events = POLLIN};
        }
    }
    /* The time-out is for a signal that came just before. */
    if (poll(wait, count, 1000) <= 0)
        return;
    for (nfds_t i = 0; i < count; i++) {
        if (wait[i].revents)
            take_messages(b, from[i]);
    }
}

static void stop_all(batch *b)
{
    for (size_t i = 0; i < b->count; i++) {
        if (b->task[i].process && b->task[i].pipe >= 0)
            kill(b->task[i].process, SIGTERM);
    }
    while (b->running)
        listen(b);
}

static hpr_status run_tasks(batch *b)
{
    for (;;) {
        if (hpr_cancelled(b->context)) {
            b->stopping = true;
            stop_all(b);
            return hpr_fail(b->context, HPR_ERR_INTERRUPTED,
                            "interrupted; the same command goes on from here");
        }
        start_ready(b);
        if (!b->running)
            return HPR_OK;
        listen(b);
    }
}

/* Says what each task would make, and what is there. */
static hpr_status tell_tasks(batch *b, hpr_manifest *manifest)
{
    for (size_t i = 0; i < b->count; i++) {
        const task *t = b->task + i;
        const hpr_batch_group *group = b->plan->group + t->index;
        const hpr_batch_solution *solution =
            b->plan->solution + (t->kind == HPR_BATCH_SOLVE ? t->index : group->solution);
        if (hpr_cancelled(b->context))
            return hpr_fail(b->context, HPR_ERR_INTERRUPTED, "interrupted");
        if (solution->trouble) {
            b->result->failed += t->kind == HPR_BATCH_SOLVE;
            say(b, t->kind == HPR_BATCH_SOLVE ? HPR_BATCH_FAILED : HPR_BATCH_LEFT_OUT, name_of(b, t),
                solution->trouble, false);
            continue;
        }
        if (t->kind == HPR_BATCH_SOLVE)
            say(b, HPR_BATCH_PLANNED, solution->path, "",
                hpr_manifest_find(manifest, solution->path, solution->key) != NULL);
        for (size_t k = 0; t->kind == HPR_BATCH_RENDER && k < group->pictures.count; k++) {
            const char *file[HPR_BATCH_FILES];
            char key[HPR_SHA256_TEXT];
            size_t files = hpr_batch_picture_files(group, k, file);
            hpr_batch_picture_key(group, k, key);
            for (size_t f = 0; f < files; f++)
                say(b, HPR_BATCH_PLANNED, file[f], "", hpr_manifest_find(manifest, file[f], key) != NULL);
        }
    }
    return HPR_OK;
}

/* Makes the folders above a file. */
static hpr_status make_folders(hpr_context *ctx, const char *path)
{
    char *text = hpr_duplicate_text(ctx, path);
    hpr_status status = text ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a folder's name");
    for (char *slash = text ? strchr(text + 1, '/') : NULL; slash && status == HPR_OK;
         slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(text, 0777) != 0 && errno != EEXIST)
            status = hpr_fail(ctx, HPR_ERR_IO, "cannot make the folder '%s': %s", text, strerror(errno));
        *slash = '/';
    }
    hpr_release(ctx, text);
    return status;
}

static hpr_status prepare_folders(const hpr_batch_plan *plan)
{
    hpr_status status = HPR_OK;
    for (size_t i = 0; i < plan->solution_count && status == HPR_OK; i++)
        status = make_folders(plan->context, plan->solution[i].path);
    for (size_t g = 0; g < plan->group_count && status == HPR_OK; g++) {
        const hpr_pictures *pictures = &plan->group[g].pictures;
        for (size_t i = 0; i < pictures->count && pictures->files && status == HPR_OK; i++)
            status = make_folders(plan->context, pictures->files[i].exr);
    }
    return status;
}

static hpr_status run(batch *b)
{
    hpr_manifest manifest = {0};
    hpr_status status = list_tasks(b);
    if (status == HPR_OK && !b->options->dry_run)
        status = prepare_folders(b->plan);
    if (status == HPR_OK && b->options->dry_run)
        status = hpr_manifest_open(b->context, b->plan->folder, false, &manifest);
    if (status == HPR_OK)
        status = b->options->dry_run ? tell_tasks(b, &manifest) : run_tasks(b);
    hpr_manifest_close(&manifest);
    hpr_release(b->context, b->task);
    return status;
}

hpr_status hpr_job_batch(hpr_context *ctx, const char *path, const hpr_batch_options *options,
                         hpr_batch_result *result)
{
    hpr_batch_options defaults;
    hpr_batch_options_init(&defaults);
    options = options ? options : &defaults;
    *result = (hpr_batch_result){0};
    hpr_context_clear_error(ctx);
    if (options->jobs < 1 || options->jobs > MAX_JOBS || options->shard_count < 1 || options->shard < 1 ||
        options->shard > options->shard_count || !(options->memory_bytes >= 0))
        return hpr_fail(ctx, HPR_ERR_ARG, "a batch of %d jobs at a time, shard %d of %d, is none",
                        options->jobs, options->shard, options->shard_count);
    hpr_batch_spec spec;
    hpr_batch_plan plan = {0};
    batch b = {.context = ctx,
               .plan = &plan,
               .options = options,
               .result = result,
               .memory_bytes = options->memory_bytes > 0 ? options->memory_bytes : 0.9 * hpr_machine_bytes()};
    hpr_status status = hpr_batch_spec_read(ctx, path, &spec);
    if (status == HPR_OK)
        status = hpr_batch_plan_make(ctx, &spec, &plan);
    if (status == HPR_OK)
        status = run(&b);
    hpr_batch_plan_release(&plan);
    hpr_batch_spec_release(&spec);
    return status;
}
