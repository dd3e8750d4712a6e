/* Jobs through the public header: what the command cannot show. */
#include <hprad/job.h>

#include "failing_allocator.h"
#include "io_support.h"

/* A square of side 1 in the plane y = 0: four positions, six indices. */
#define SQUARE "AAAAvwAAAAAAAAA/AAAAPwAAAAAAAAA/AAAAPwAAAAAAAAC/AAAAvwAAAAAAAAC/AAABAAIAAAACAAMA"

/* A lit floor and a camera; ' stands for ". */
static const char scene_text[] =
    "{'asset':{'version':'2.0'},'scene':0,'scenes':[{'nodes':[0,1,2]}],'nodes':[{'mesh':0},"
    "{'mesh':1,'matrix':[0.5,0,0,0,0,-0.5,0,0,0,0,-0.5,0,0,0.5,0,1]},"
    "{'camera':0,'name':'eye','matrix':[1,0,0,0,0,0,-1,0,0,1,0,0,0,2,0,1]}],"
    "'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':0}]},"
    "{'primitives':[{'attributes':{'POSITION':0},'indices':1,'material':1}]}],"
    "'materials':[{'pbrMetallicRoughness':{'metallicFactor':0,'baseColorFactor':[0.8,0.5,0.2,1]}},"
    "{'pbrMetallicRoughness':{'metallicFactor':0},'emissiveFactor':[1,1,0.5]}],"
    "'buffers':[{'byteLength':60,'uri':'data:application/octet-stream;base64," SQUARE "'}],"
    "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':12}],"
    "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','min':[-0.5,0,-0.5],"
    "'max':[0.5,0,0.5]},{'bufferView':1,'componentType':5123,'count':6,'type':'SCALAR'}],"
    "'cameras':[{'type':'perspective','perspective':{'yfov':0.8,'znear':0.01,'aspectRatio':1}}]}";

/* Writes the scene; everything happens in the test's folder. */
static int job_setup(void **state)
{
    if (fixture_setup(state) != 0)
        return -1;
    fixture *f = *state;
    char text[sizeof scene_text];
    for (size_t i = 0; i < sizeof text; i++)
        text[i] = (char)(scene_text[i] == '\'' ? '"' : scene_text[i]);
    spill(in_folder(f, "s.gltf"), text, sizeof text - 1);
    return chdir(f->folder);
}

static int job_teardown(void **state)
{
    return chdir("/") == 0 ? fixture_teardown(state) : -1;
}

static hpr_job_picture_options small_picture(void)
{
    hpr_job_picture_options options;
    hpr_job_picture_options_init(&options);
    options.solve.order = options.solve.subdivide = 0;
    options.pictures.render = (hpr_render_options){.width = 4, .height = 4, .samples = 1};
    return options;
}

static void options_and_result_may_be_left_out(void **state)
{
    fixture *f = *state;
    assert_int_equal(hpr_job_solve(f->context, "s.gltf", NULL, NULL), HPR_OK);
    assert_int_equal(access("s.glb", F_OK), 0);
    assert_int_equal(hpr_job_render(f->context, "s.glb", NULL, NULL), HPR_OK);
    assert_int_equal(access("s.exr", F_OK), 0);
    assert_int_equal(remove("s.exr"), 0);
    assert_int_equal(hpr_job_picture(f->context, "s.gltf", NULL, NULL), HPR_OK);
    assert_int_equal(access("s.exr", F_OK), 0);
}

typedef struct record {
    size_t count;
    hpr_job_kind kind[4];
    char text[4][64]; /* path and camera */
} record;

static void note(void *user, const hpr_job_file *file)
{
    record *r = user;
    assert_true(r->count < 4);
    assert_int_equal(access(file->path, F_OK), 0); /* it is there when it is announced */
    r->kind[r->count] = file->kind;
    snprintf(r->text[r->count++], sizeof r->text[0], "%s %s", file->path, file->camera ? file->camera : "-");
}

static void files_are_announced_in_order(void **state)
{
    fixture *f = *state;
    record r = {0};
    hpr_job_result result;
    hpr_job_picture_options options = small_picture();
    options.pictures.report_path = "r.json";
    options.pictures.preview = 1;
    options.pictures.pattern = "{camera}{frame:02}.exr";
    options.pictures.events = (hpr_job_events){.wrote = note, .user = &r};
    assert_int_equal(hpr_job_picture(f->context, "s.gltf", &options, &result), HPR_OK);
    assert_int_equal(r.count, 3);
    assert_int_equal(r.kind[0], HPR_JOB_FILE_EXR);
    assert_int_equal(r.kind[1], HPR_JOB_FILE_PNG);
    assert_int_equal(r.kind[2], HPR_JOB_FILE_REPORT);
    assert_string_equal(r.text[0], "eye00.exr eye");
    assert_string_equal(r.text[1], "eye00.png eye");
    assert_string_equal(r.text[2], "r.json -");
    assert_int_equal(result.picture_count, 1);
    assert_int_equal(result.summary.patch_count, 2);
    assert_true(result.seconds >= result.solve_seconds && result.solve_seconds > 0);
}

static void the_step_tells_inputs_from_outputs(void **state)
{
    fixture *f = *state;
    hpr_job_result result;
    hpr_job_solve_options options;
    hpr_job_solve_options_init(&options);
    assert_int_equal(hpr_job_solve(f->context, "none.gltf", NULL, &result), HPR_ERR_IO);
    assert_int_equal(result.step, HPR_JOB_READ);
    options.solution_path = "none/x.glb";
    assert_int_equal(hpr_job_solve(f->context, "s.gltf", &options, &result), HPR_ERR_IO);
    assert_int_equal(result.step, HPR_JOB_CHECK);
    options.solution_path = "/dev/full";
    assert_int_equal(hpr_job_solve(f->context, "s.gltf", &options, &result), HPR_ERR_IO);
    assert_int_equal(result.step, HPR_JOB_WRITE);
    options.solution_path = "x.glb";
    options.solve.order = HPR_MAX_ORDER + 1;
    assert_int_equal(hpr_job_solve(f->context, "s.gltf", &options, &result), HPR_ERR_ARG);
    assert_int_equal(result.step, HPR_JOB_SOLVE);
}

static void a_cancelled_job_writes_nothing(void **state)
{
    fixture *f = *state;
    f->cancel = 1;
    hpr_job_result result;
    assert_int_equal(hpr_job_solve(f->context, "s.gltf", NULL, &result), HPR_ERR_INTERRUPTED);
    assert_int_equal(hpr_job_picture(f->context, "s.gltf", NULL, &result), HPR_ERR_INTERRUPTED);
    assert_int_equal(count_files(f->folder, false), 1);
    f->cancel = 0;
}

static hpr_status run_picture(hpr_context *ctx, void *data)
{
    (void)data;
    hpr_job_picture_options options = small_picture();
    options.pictures.preview = 1;
    options.pictures.report_path = "r.json";
    return hpr_job_picture(ctx, "s.gltf", &options, NULL);
}

static void a_job_survives_without_memory(void **state)
{
    fixture *f = *state;
    size_t calls = sweep_allocations(run_picture, NULL, 1);
    print_message("%zu allocations\n", calls);
    assert_int_equal(count_files(f->folder, false),
                     4); /* scene, picture, preview, report; nothing temporary */
}

#define JOB_TEST(test) cmocka_unit_test_setup_teardown(test, job_setup, job_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        JOB_TEST(options_and_result_may_be_left_out), JOB_TEST(files_are_announced_in_order),
        JOB_TEST(the_step_tells_inputs_from_outputs), JOB_TEST(a_cancelled_job_writes_nothing),
        JOB_TEST(a_job_survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
