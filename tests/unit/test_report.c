#include "solver/solution.h"

#include "io_support.h"

#include <cjson/cJSON.h>
#include <hprad/report.h>
#include <hprad/version.h>

/* Two channels, numbers that need 17 digits. */
static hpr_energy energy[2] = {{10, 2.5, 10.0 / 3, 1.0 / 7, 6.5}, {0, 0, 0, 0, 0}};
static double environment[2] = {0.1 + 0.2, 0};
static char *names[2] = {"R", "x\xff"};

static hpr_solution example(fixture *f)
{
    hpr_solution s = {.context = f->context,
                      .scene_name = "box.gltf",
                      .channel_count = 2,
                      .environment = environment,
                      .energy = energy};
    s.channel_name = names;
    s.summary = (hpr_solve_summary){
        .error_estimate = 0.0375,
        .error_parts = {0.025, 0.0078125, 0.00390625, 0.00078125},
        .steps = 6,
        .options = {.order = 2, .subdivide = 3, .feet = 1, .solver_tolerance = 1e-12, .max_sweeps = 100},
        .blocked_tolerance = 1e-3,
        .visibility_error = 0.0025,
        .link_tolerance = 1e-4,
        .link_error = 3e-5,
        .solver = HPR_SOLVER_GMRES,
        .environment = HPR_ENVIRONMENT_EXACT,
        .environment_closed = 5,
        .environment_clipped = 6,
        .environment_sampled = 7,
        .environment_error = 1.0 / 3,
        .patch_count = 11,
        .element_count = 704,
        .dof_count = 6336,
        .link_count = (size_t)1 << 40,
        .block_bytes = 12345,
        .channels_solved = 2,
        .degenerate_count = 1,
        .duplicate_count = 4,
        .block_tolerance = 1e-6,
        .short_count = 9,
        .block_error = 1e-12 / 3,
        .sampled_error = 1e-2 / 3,
        .sweeps = 17,
        .residual = 0.1 + 0.2,
        .occluded = 1};
    return s;
}

static cJSON *write_and_parse(fixture *f, const char *scene_path)
{
    hpr_solution s = example(f);
    assert_int_equal(hpr_report_write(f->context, &s, scene_path, in_folder(f, "r.json")), HPR_OK);
    size_t bytes;
    char *text = (char *)slurp(in_folder(f, "r.json"), &bytes);
    assert_true(text[bytes - 1] == '\n');
    cJSON *root = cJSON_Parse(text);
    assert_non_null(root);
    free(text);
    return root;
}

/* The item at a path such as "energy/0/emitted". */
static const cJSON *item_at(const cJSON *root, const char *path)
{
    char copy[128];
    snprintf(copy, sizeof copy, "%s", path);
    for (char *part = strtok(copy, "/"); part; part = strtok(NULL, "/")) {
        root = cJSON_IsArray(root) ? cJSON_GetArrayItem(root, atoi(part))
                                   : cJSON_GetObjectItemCaseSensitive(root, part);
        if (!root)
            fail_msg("no '%s' in '%s'", part, path);
    }
    return root;
}

static void keys_are_as_documented(void **state)
{
    fixture *f = *state;
    hpr_count(f->context, HPR_COUNT_RAYS, 5000000000u);
    hpr_count(f->context, HPR_COUNT_PAIRS_PARTIAL, 3);
    hpr_count(f->context, HPR_COUNT_ROUNDED, 5);
    hpr_stage_begin(f->context, "solve");
    hpr_stage_end(f->context);
    hpr_warn(f->context, "first \"warning\"");
    cJSON *root = write_and_parse(f, "scenes/box.gltf");
    static const struct {
        const char *path;
        double value;
    } numbers[] = {
        {"threads", 1},
        {"settings/order", 2},
        {"error_estimate", 0.0375},
        {"error_parts/discretisation", 0.025},
        {"error_parts/links", 0.0078125},
        {"error_parts/visibility", 0.00390625},
        {"error_parts/solver", 0.00078125},
        {"counts/steps", 6},
        {"settings/subdivide", 3},
        {"settings/feet", 1},
        {"settings/block_tolerance", 1e-6},
        {"settings/blocked_tolerance", 1e-3},
        {"visibility_error", 0.0025},
        {"settings/link_tolerance", 1e-4},
        {"link_error", 3e-5},
        {"settings/solver_tolerance", 1e-12},
        {"settings/max_sweeps", 100},
        {"counts/patches", 11},
        {"counts/elements", 704},
        {"counts/dofs", 6336},
        {"counts/links", 1099511627776.0},
        {"counts/block_bytes", 12345},
        {"counts/channels", 2},
        {"counts/channels_solved", 2},
        {"counts/degenerate", 1},
        {"counts/duplicate", 4},
        {"counters/kernel_evaluations", 0},
        {"counters/rays", 5e9},
        {"counters/camera_rays", 0},
        {"counters/blocks", 0},
        {"counters/blocks_sampled", 0},
        {"counters/clips", 0},
        {"counters/blocks_short", 0},
        {"counters/blocks_rounded", 5},
        {"counters/pairs_hidden", 0},
        {"counters/pairs_visible", 0},
        {"counters/pairs_partial", 3},
        {"solver/sweeps", 17},
        {"solver/residual", 0.1 + 0.2},
        {"solver/blocks_short", 9},
        {"quadrature/block_error", 1e-12 / 3},
        {"quadrature/sampled_error", 1e-2 / 3},
        {"environment/radiance/0", 0.1 + 0.2},
        {"environment/radiance/1", 0},
        {"environment/elements_closed_form", 5},
        {"environment/elements_clipped", 6},
        {"environment/elements_sampled", 7},
        {"environment/error", 1.0 / 3},
        {"energy/0/emitted", 10},
        {"energy/0/environment", 2.5},
        {"energy/0/absorbed", 10.0 / 3},
        {"energy/0/lost_on_backs", 1.0 / 7},
        {"energy/0/escaped", 6.5},
        {"energy/0/balance", 12.5 - 10.0 / 3 - 1.0 / 7 - 6.5},
        {"energy/0/relative", (12.5 - 10.0 / 3 - 1.0 / 7 - 6.5) / 12.5},
        {"energy/1/relative", 0},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        double value = item_at(root, numbers[i].path)->valuedouble;
        if (value != numbers[i].value)
            fail_msg("%s: %.17g, not %.17g", numbers[i].path, value, numbers[i].value);
    }
    assert_true(cJSON_IsTrue(item_at(root, "solver/occluded")));
    assert_string_equal(item_at(root, "environment/direct")->valuestring, "exact");
    assert_true(cJSON_IsNull(item_at(root, "settings/tolerance")));
    assert_string_equal(item_at(root, "settings/refine")->valuestring, "hp");
    assert_string_equal(item_at(root, "hprad/version")->valuestring, hpr_version());
    assert_string_equal(item_at(root, "hprad/commit")->valuestring, hpr_commit());
    assert_string_equal(item_at(root, "hprad/embree")->valuestring, hpr_embree_version());
    assert_string_equal(item_at(root, "isa")->valuestring, hpr_context_isa(f->context));
    assert_string_equal(item_at(root, "scene")->valuestring, "scenes/box.gltf");
    assert_string_equal(item_at(root, "energy/0/channel")->valuestring, "R");
    assert_string_equal(item_at(root, "energy/1/channel")->valuestring, "x\xef\xbf\xbd");
    assert_string_equal(item_at(root, "stages/0/name")->valuestring, "solve");
    assert_true(item_at(root, "stages/0/wall_seconds")->valuedouble >= 0);
    assert_true(item_at(root, "stages/0/cpu_seconds")->valuedouble >= 0);
    assert_string_equal(item_at(root, "warnings/0")->valuestring, "first \"warning\"");
    assert_true(item_at(root, "cpu_seconds")->valuedouble > 0);
    assert_true(item_at(root, "peak_memory_bytes")->valuedouble > 1e6);
    cJSON_Delete(root);
}

static void scene_defaults_to_its_name(void **state)
{
    fixture *f = *state;
    cJSON *root = write_and_parse(f, NULL);
    assert_string_equal(item_at(root, "scene")->valuestring, "box.gltf");
    cJSON_Delete(root);
}

static void no_number_is_null(void **state)
{
    fixture *f = *state;
    energy[1].absorbed = NAN;
    cJSON *root = write_and_parse(f, NULL);
    energy[1].absorbed = 0;
    assert_true(cJSON_IsNull(item_at(root, "energy/1/absorbed")));
    assert_true(cJSON_IsNull(item_at(root, "energy/1/balance")));
    cJSON_Delete(root);
}

static void failures_leave_nothing(void **state)
{
    fixture *f = *state;
    hpr_solution s = example(f);
    assert_int_equal(hpr_report_write(f->context, &s, NULL, "/dev/full"), HPR_ERR_IO);
    assert_message_has(f, "No space left");
    assert_int_equal(hpr_report_write(f->context, &s, NULL, f->folder), HPR_ERR_IO);
    f->cancel = 1;
    assert_int_equal(hpr_report_write(f->context, &s, NULL, in_folder(f, "r.json")), HPR_ERR_INTERRUPTED);
    f->cancel = 0;
    for (long k = 0;; k++) {
        f->allocations_left = k;
        hpr_status status = hpr_report_write(f->context, &s, NULL, in_folder(f, "r.json"));
        f->allocations_left = -1;
        assert_int_equal(count_files(f->folder, false), status == HPR_OK);
        if (status == HPR_OK)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {IO_TEST(keys_are_as_documented), IO_TEST(scene_defaults_to_its_name),
                                       IO_TEST(no_number_is_null), IO_TEST(failures_leave_nothing)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
