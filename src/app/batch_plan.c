#include "app/batch_plan.h"

#include "app/names.h"
#include "app/scene_hash.h"

#include <hprad/version.h>
#include <stdio.h>
#include <string.h>

/* A path that the batch file names: relative to its folder. Caller releases; NULL: no memory. */
static char *resolve(const hpr_batch_spec *spec, const char *path)
{
    const char *slash = strrchr(spec->path, '/');
    if (path[0] == '/' || !slash)
        return hpr_duplicate_text(spec->context, path);
    size_t folder = (size_t)(slash - spec->path) + 1;
    char *text = hpr_allocate(spec->context, folder + strlen(path) + 1, 1);
    if (text) {
        memcpy(text, spec->path, folder);
        strcpy(text + folder, path);
    }
    return text;
}

static char *join(hpr_context *ctx, const char *a, const char *b, const char *c)
{
    size_t bytes = strlen(a) + strlen(b) + strlen(c) + 1;
    char *text = hpr_allocate(ctx, bytes, 1);
    if (text)
        snprintf(text, bytes, "%s%s%s", a, b, c);
    return text;
}

static hpr_status no_memory(hpr_context *ctx)
{
    return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for the plan of a batch");
}

/* Adds what an entry of the batch file says, without its name: so a renamed setting is still the same. */
static bool add_entry(hpr_sha256 *hash, const cJSON *item, const char *const *left_out)
{
    cJSON *copy = item ? cJSON_Duplicate(item, true) : cJSON_CreateObject();
    if (cJSON_IsObject(copy)) {
        for (; *left_out; left_out++)
            cJSON_DeleteItemFromObjectCaseSensitive(copy, *left_out);
    }
    char *text = cJSON_IsString(copy) ? NULL : cJSON_PrintUnformatted(copy);
    bool ok = copy && (text || cJSON_IsString(copy));
    hpr_sha256_add_text(hash, text && strcmp(text, "{}") != 0 ? text : "");
    cJSON_free(text);
    cJSON_Delete(copy);
    return ok;
}

static hpr_status find_key(const hpr_batch_plan *plan, hpr_batch_solution *solution)
{
    static const char *const scene_names[] = {"name", "file", NULL}, *const setting_names[] = {"name", NULL};
    hpr_sha256 hash;
    hpr_sha256_init(&hash);
    hpr_sha256_add_text(&hash, hpr_version());
    hpr_sha256_add_text(&hash, hpr_commit());
    hpr_sha256_add_text(&hash, hpr_context_isa(plan->context));
    bool ok = add_entry(&hash, solution->scene->item, scene_names) &&
              add_entry(&hash, solution->setting->item, setting_names);
    const char *slash = strrchr(solution->scene_path, '/'); /* a solution holds the name */
    hpr_sha256_add_text(&hash, slash ? slash + 1 : solution->scene_path);
    hpr_status status = hpr_scene_hash_add(plan->context, &hash, solution->scene_path);
    hpr_sha256_finish(&hash, solution->key);
    return ok ? status : no_memory(plan->context);
}

/* A file that cannot be read is trouble for what needs it only. */
static hpr_status note_trouble(hpr_context *ctx, hpr_status status, char **trouble)
{
    if (status == HPR_OK || status == HPR_ERR_MEMORY || status == HPR_ERR_INTERRUPTED)
        return status;
    if (!*trouble)
        *trouble = hpr_duplicate_text(ctx, hpr_context_error(ctx));
    hpr_context_clear_error(ctx);
    return *trouble ? HPR_OK : no_memory(ctx);
}

static hpr_status plan_solution(const hpr_batch_plan *plan, hpr_batch_solution *solution)
{
    char name[32];
    solution->scene_path = resolve(plan->spec, solution->scene->file);
    if (!solution->scene_path)
        return no_memory(plan->context);
    hpr_status status = note_trouble(plan->context, find_key(plan, solution), &solution->trouble);
    snprintf(name, sizeof name, "%.16s", solution->key);
    char *stem = join(plan->context, plan->folder, "/solutions/", name);
    solution->path = stem ? join(plan->context, stem, ".glb", "") : NULL;
    hpr_release(plan->context, stem);
    return solution->path ? status : no_memory(plan->context);
}

/* Puts names into {scene} and {setting}; caller releases. NULL: no memory. */
static char *fill_in(hpr_context *ctx, const char *pattern, const char *scene, const char *setting)
{
    const struct {
        const char *word, *text;
    } known[] = {{"{scene}", scene}, {"{setting}", setting}};
    char *text = hpr_duplicate_text(ctx, pattern);
    for (int i = 0; i < 2; i++) {
        for (char *at; text && (at = strstr(text, known[i].word)) != NULL;) {
            *at = '\0';
            char *next = join(ctx, text, known[i].text, at + strlen(known[i].word));
            hpr_release(ctx, text);
            text = next;
        }
    }
    return text;
}

static hpr_status name_group(hpr_batch_plan *plan, hpr_batch_group *group)
{
    const hpr_batch_solution *solution = plan->solution + group->solution;
    const char *pattern = group->camera->pictures ? group->camera->pictures : plan->spec->pictures;
    char *name = fill_in(plan->context, pattern, solution->scene->name, solution->setting->name);
    group->pattern = name ? join(plan->context, plan->folder, "/", name) : NULL;
    hpr_release(plan->context, name);
    if (!group->pattern)
        return no_memory(plan->context);
    group->options = group->camera->options;
    group->options.pattern = group->pattern;
    if (group->options.camera_file) {
        group->camera_file = resolve(plan->spec, group->options.camera_file);
        if (!group->camera_file)
            return no_memory(plan->context);
        group->options.camera_file = group->camera_file;
    }
    return hpr_name_check(plan->context, group->pattern);
}

static hpr_status find_group_key(const hpr_batch_plan *plan, hpr_batch_group *group)
{
    static const char *const names[] = {"pictures", "frames", "camera_file", NULL};
    hpr_status status = HPR_OK;
    hpr_sha256 hash;
    hpr_sha256_init(&hash);
    hpr_sha256_add_text(&hash, plan->solution[group->solution].key);
    bool ok = add_entry(&hash, group->camera->item, names);
    if (group->camera_file)
        status = hpr_scene_hash_add(plan->context, &hash, group->camera_file);
    hpr_sha256_finish(&hash, group->key);
    return ok ? status : no_memory(plan->context);
}

/* The pictures of a group, by the cameras of `scene`. */
static hpr_status plan_group(hpr_batch_plan *plan, hpr_job *job, const hpr_scene *scene,
                             hpr_batch_group *group)
{
    hpr_status status = name_group(plan, group);
    if (status != HPR_OK)
        return status;
    const hpr_picture_source source = {.path = plan->solution[group->solution].scene_path,
                                       .tail = ".exr",
                                       .camera_count = scene->camera_count,
                                       .camera = scene->camera};
    status = find_group_key(plan, group);
    return status == HPR_OK ? hpr_pictures_plan(job, &group->options, &source, &group->pictures) : status;
}

static hpr_status plan_groups(hpr_batch_plan *plan, hpr_job *job, size_t solution)
{
    hpr_scene *scene = NULL;
    hpr_batch_solution *from = plan->solution + solution;
    hpr_status status = HPR_OK;
    if (!from->trouble)
        status =
            note_trouble(plan->context,
                         hpr_scene_read_cameras(plan->context, from->scene_path, &from->scene->read, &scene),
                         &from->trouble);
    for (size_t c = 0; c < plan->spec->camera_count && status == HPR_OK; c++) {
        hpr_batch_group *group = plan->group + plan->group_count++;
        group->solution = solution;
        group->camera = plan->spec->camera + c;
        if (!from->trouble)
            status = plan_group(plan, job, scene, group);
    }
    hpr_scene_destroy(&scene);
    return status;
}

hpr_status hpr_batch_plan_make(hpr_context *ctx, const hpr_batch_spec *spec, hpr_batch_plan *plan)
{
    size_t solutions = spec->scene_count * spec->setting_count;
    hpr_job job;
    hpr_job_begin(&job, ctx, &(hpr_job_events){0}, NULL);
    job.outputs.names_only = true;
    *plan = (hpr_batch_plan){.context = ctx, .spec = spec};
    hpr_status status =
        hpr_allocate_into(ctx, &plan->solution, solutions, sizeof *plan->solution, "the plan of a batch");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &plan->group, solutions * spec->camera_count, sizeof *plan->group,
                                   "the plan of a batch");
    if (status == HPR_OK) {
        plan->folder = resolve(spec, spec->folder);
        status = plan->folder ? HPR_OK : no_memory(ctx);
    }
    for (size_t i = 0; i < solutions && status == HPR_OK; i++) {
        hpr_batch_solution *solution = plan->solution + plan->solution_count++;
        solution->scene = spec->scene + i / spec->setting_count;
        solution->setting = spec->setting + i % spec->setting_count;
        status = plan_solution(plan, solution);
        if (status == HPR_OK)
            status = plan_groups(plan, &job, i);
    }
    return hpr_job_end(&job, status);
}

void hpr_batch_plan_release(hpr_batch_plan *plan)
{
    hpr_context *ctx = plan->context;
    for (size_t i = 0; i < plan->group_count; i++) {
        hpr_pictures_release(ctx, &plan->group[i].pictures);
        hpr_release(ctx, plan->group[i].pattern);
        hpr_release(ctx, plan->group[i].camera_file);
    }
    for (size_t i = 0; i < plan->solution_count; i++) {
        hpr_release(ctx, plan->solution[i].scene_path);
        hpr_release(ctx, plan->solution[i].path);
        hpr_release(ctx, plan->solution[i].trouble);
    }
    if (ctx) {
        hpr_release(ctx, plan->solution);
        hpr_release(ctx, plan->group);
        hpr_release(ctx, plan->folder);
    }
    *plan = (hpr_batch_plan){0};
}

void hpr_batch_picture_key(const hpr_batch_group *group, size_t i, char key[HPR_SHA256_TEXT])
{
    char number[48];
    hpr_sha256 hash;
    snprintf(number, sizeof number, "%zu %zu", hpr_pictures_camera(&group->pictures, i),
             group->pictures.first + i);
    hpr_sha256_init(&hash);
    hpr_sha256_add_text(&hash, group->key);
    hpr_sha256_add_text(&hash, number);
    hpr_sha256_finish(&hash, key);
}

size_t hpr_batch_picture_files(const hpr_batch_group *group, size_t i, const char *file[HPR_BATCH_FILES])
{
    const hpr_picture_files *files = group->pictures.files + i;
    size_t count = 0;
    file[count++] = files->exr;
    if (files->png)
        file[count++] = files->png;
    if (files->false_colour)
        file[count++] = files->false_colour;
    return count;
}
