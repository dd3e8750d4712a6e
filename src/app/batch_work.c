#include "app/batch_work.h"

#include "app/manifest.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

_Static_assert(sizeof(hpr_batch_message) <= PIPE_BUF, "messages must come through a pipe whole");

typedef struct worker {
    const hpr_batch_plan *plan;
    const hpr_batch_means *means;
    hpr_context *context;
    hpr_manifest manifest;
    const hpr_batch_group *group; /* whose pictures are being made */
    size_t first;                 /* the first of the run that is being made */
    size_t finished;              /* pictures of it that are done */
    size_t files;                 /* files of the next one that are done */
    hpr_status status;            /* of noting them */
    hpr_batch_message end;
} worker;

static void send(const worker *w, const hpr_batch_message *message)
{
    /* If nobody reads any more, there is nobody to tell. */
    ssize_t sent = write(w->means->pipe, message, sizeof *message);
    (void)sent;
}

static void send_text(const worker *w, hpr_batch_message_kind kind, const char *path, const char *text)
{
    hpr_batch_message message = {.kind = kind};
    snprintf(message.path, sizeof message.path, "%s", path);
    snprintf(message.text, sizeof message.text, "%s", text);
    send(w, &message);
}

static void pass_warning(void *user, hpr_log_level level, const char *text)
{
    if (level == HPR_LOG_WARNING)
        send_text(user, HPR_BATCH_MESSAGE_WARNING, "", text);
}

static hpr_status make_solution(worker *w, const hpr_batch_solution *solution)
{
    const hpr_batch_scene *scene = solution->scene;
    const hpr_job_solve_options options = {.solution_path = solution->path,
                                           .read = scene->read,
                                           .solve = solution->setting->solve,
                                           .environment_count = scene->environment_count,
                                           .environment = scene->environment};
    hpr_manifest_tidy(solution->path);
    hpr_status status = hpr_job_solve(w->context, solution->scene_path, &options, NULL);
    bool missed = status == HPR_ERR_TOLERANCE; /* then the solution is written all the same */
    if (status != HPR_OK && !missed)
        return status;
    if (missed)
        send_text(w, HPR_BATCH_MESSAGE_WARNING, "", hpr_context_error(w->context));
    w->end.made = 1;
    w->end.missed = missed;
    const char *path = solution->path;
    const hpr_manifest_entry entry = {&path, 1, solution->key, missed};
    status = hpr_manifest_add(&w->manifest, &entry);
    if (status == HPR_OK)
        send_text(w, HPR_BATCH_MESSAGE_WROTE, solution->path, "");
    return status;
}

/* Another batch may be solving the same: then this one waits, and takes what comes of it. */
static hpr_status solve(worker *w, const hpr_batch_solution *solution)
{
    bool locked;
    hpr_status status = hpr_manifest_lock(&w->manifest, solution->path, true, &locked);
    if (status == HPR_OK)
        status = hpr_manifest_update(&w->manifest);
    if (status != HPR_OK)
        return status;
    const hpr_manifest_line *line = hpr_manifest_find(&w->manifest, solution->path, solution->key);
    if (line) {
        w->end.reused = 1;
        w->end.missed = line->missed;
        hpr_manifest_tidy(solution->path);
    } else {
        status = make_solution(w, solution);
    }
    hpr_manifest_unlock(&w->manifest, solution->path);
    return status;
}

static bool is_finished(worker *w, const hpr_batch_group *group, size_t i)
{
    const char *file[HPR_BATCH_FILES];
    char key[HPR_SHA256_TEXT];
    size_t count = hpr_batch_picture_files(group, i, file);
    hpr_batch_picture_key(group, i, key);
    for (size_t k = 0; k < count; k++) {
        if (!hpr_manifest_find(&w->manifest, file[k], key))
            return false;
    }
    return true;
}

/* Tells of each file as it is finished, and notes those of a picture, which come one after the other, with
 * the last: it is finished when all are. */
static void note_file(void *user, const hpr_job_file *file)
{
    worker *w = user;
    const char *name[HPR_BATCH_FILES];
    char key[HPR_SHA256_TEXT];
    size_t i = w->first + w->finished, count = hpr_batch_picture_files(w->group, i, name);
    bool last = ++w->files == count;
    if (w->status == HPR_OK && last) {
        hpr_batch_picture_key(w->group, i, key);
        const hpr_manifest_entry entry = {name, count, key, false};
        w->status = hpr_manifest_add(&w->manifest, &entry);
    }
    if (w->status == HPR_OK)
        send_text(w, HPR_BATCH_MESSAGE_WROTE, file->path, "");
    if (last) {
        w->files = 0;
        w->finished++;
        w->end.made++;
    }
}

/* Renders pictures first ... first + count - 1 of the group. */
static hpr_status render_run(worker *w, const hpr_batch_group *group, size_t first, size_t count)
{
    hpr_job_render_options options = group->options;
    const char *file[HPR_BATCH_FILES];
    for (size_t i = first; i < first + count; i++) {
        size_t files = hpr_batch_picture_files(group, i, file);
        for (size_t k = 0; k < files; k++)
            hpr_manifest_tidy(file[k]);
    }
    options.first_frame = (int)(group->pictures.first + first);
    options.frame_count = (int)count;
    options.events = (hpr_job_events){.wrote = note_file, .user = w};
    w->group = group;
    w->first = first;
    w->finished = w->files = 0;
    hpr_status status = hpr_job_render(w->context, w->plan->solution[group->solution].path, &options, NULL);
    return status == HPR_OK ? w->status : status;
}

/* Pictures that another batch is making are left for later: who holds a lock must not wait for another. */
static hpr_status render_free(worker *w, const hpr_batch_group *group, bool *done)
{
    size_t count = group->pictures.count, first = 0, run = 0;
    hpr_status status = HPR_OK;
    for (size_t i = 0; i <= count && status == HPR_OK; i++) {
        bool mine = false;
        if (i < count && !(done[i] = is_finished(w, group, i)))
            status = hpr_manifest_lock(&w->manifest, group->pictures.files[i].exr, false, &mine);
        if (mine && status == HPR_OK)
            status = hpr_manifest_update(&w->manifest);
        if (mine && status == HPR_OK && (done[i] = is_finished(w, group, i))) {
            hpr_manifest_unlock(&w->manifest, group->pictures.files[i].exr);
            mine = false;
        }
        if (i < count)
            w->end.reused += done[i];
        if (mine) {
            first = run++ ? first : i;
            continue;
        }
        if (run && status == HPR_OK)
            status = render_run(w, group, first, run);
        for (; run && status == HPR_OK; run--)
            done[first + run - 1] = true;
    }
    return status;
}

static hpr_status render(worker *w, const hpr_batch_group *group)
{
    bool *done = NULL, locked;
    size_t count = group->pictures.count;
    hpr_status status = hpr_allocate_into(w->context, &done, count, sizeof *done, "a batch");
    if (status == HPR_OK)
        status = render_free(w, group, done);
    for (size_t i = 0; i < count && status == HPR_OK; i++) {
        if (done[i])
            continue;
        const char *path = group->pictures.files[i].exr;
        status = hpr_manifest_lock(&w->manifest, path, true, &locked);
        if (status == HPR_OK)
            status = hpr_manifest_update(&w->manifest);
        if (status == HPR_OK && is_finished(w, group, i))
            w->end.reused++;
        else if (status == HPR_OK)
            status = render_run(w, group, i, 1);
        hpr_manifest_unlock(&w->manifest, path);
    }
    hpr_release(w->context, done);
    return status;
}

static hpr_status open_context(worker *w)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = w->means->threads;
    options.isa = hpr_context_isa(w->plan->context);
    options.log = pass_warning;
    options.user = w;
    options.cancel = hpr_context_cancel(w->plan->context);
    return hpr_context_create(&options, &w->context);
}

void hpr_batch_work(const hpr_batch_plan *plan, hpr_batch_task_kind kind, size_t index,
                    const hpr_batch_means *means)
{
    worker w = {.plan = plan, .means = means, .end = {.kind = HPR_BATCH_MESSAGE_END}};
#ifndef HPR_SANITIZED /* sanitizers reserve more than any limit */
    const struct rlimit limit = {(rlim_t)means->memory_bytes, (rlim_t)means->memory_bytes};
    setrlimit(RLIMIT_DATA, &limit);
#endif
    hpr_status status = open_context(&w);
    if (status == HPR_OK)
        status = hpr_manifest_open(w.context, plan->folder, true, &w.manifest);
    if (status == HPR_OK)
        status =
            kind == HPR_BATCH_SOLVE ? solve(&w, plan->solution + index) : render(&w, plan->group + index);
    w.end.status = status;
    if (status != HPR_OK)
        snprintf(w.end.text, sizeof w.end.text, "%s",
                 w.context && hpr_context_error(w.context)[0] ? hpr_context_error(w.context)
                                                              : hpr_status_string(status));
    send(&w, &w.end);
    hpr_manifest_close(&w.manifest);
    hpr_context_destroy(&w.context);
}
