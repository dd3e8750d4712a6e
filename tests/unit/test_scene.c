#include "failing_allocator.h"
#include "scene/scene.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A context with a scene in it, and what was warned about. */
typedef struct fixture {
    failing_allocator allocator;
    hpr_context *ctx;
    hpr_scene *scene;
    int warnings;
    char warning[1024];
} fixture;

static void log_warning(void *user, hpr_log_level level, const char *text)
{
    fixture *f = user; /* the allocator comes first: the same `user` serves both */
    f->warnings += level == HPR_LOG_WARNING;
    snprintf(f->warning, sizeof f->warning, "%s", text);
}

static int setup(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    f->allocator.fail_at = SIZE_MAX;
    hpr_context_options options = failing_options(&f->allocator);
    options.log = log_warning;
    assert_int_equal(hpr_context_create(&options, &f->ctx), HPR_OK);
    assert_int_equal(hpr_scene_create(f->ctx, "room.gltf", 3, NULL, &f->scene), HPR_OK);
    *state = f;
    return 0;
}

static int teardown(void **state)
{
    fixture *f = *state;
    hpr_scene_destroy(&f->scene);
    hpr_context_destroy(&f->ctx);
    size_t live = f->allocator.live;
    free(f);
    assert_int_equal(live, 0);
    return 0;
}

static const double grey[3] = {0.5, 0.25, 0.125}, dark[3] = {0, 0, 0};
static const double square[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, -2};
static const uint32_t quad[] = {0, 1, 2, 3};

static hpr_mesh square_mesh(void)
{
    return (hpr_mesh){.name = "square",
                      .node = 5,
                      .primitive = 7,
                      .material = HPR_NONE,
                      .vertex_count = 4,
                      .position = square,
                      .face_count = 1,
                      .vertex = quad};
}

static hpr_camera good_camera(void)
{
    return (hpr_camera){.name = "eye",
                        .kind = HPR_CAMERA_PERSPECTIVE,
                        .right = {1, 0, 0},
                        .up = {0, 1, 0},
                        .backward = {0, 0, 1},
                        .yfov_rad = 0.7,
                        .aspect = 1.5,
                        .xmag = 1,
                        .ymag = 2,
                        .znear = 0.1,
                        .zfar = INFINITY};
}

/* The call was refused with this status and a message that holds all the texts (the last one NULL). */
static void assert_refused(fixture *f, hpr_status status, hpr_status expected, const char *const *texts)
{
    assert_int_equal(status, expected);
    for (; *texts; texts++) {
        if (!strstr(hpr_context_error(f->ctx), *texts))
            fail_msg("'%s' is not in the message '%s'", *texts, hpr_context_error(f->ctx));
    }
    hpr_context_clear_error(f->ctx);
}

#define TEXTS(...) ((const char *const[]){__VA_ARGS__, NULL})

static void an_empty_scene_has_three_channels(void **state)
{
    fixture *f = *state;
    assert_int_equal(f->scene->channel_count, 3);
    assert_string_equal(f->scene->channel_name[0], "R");
    assert_string_equal(f->scene->channel_name[2], "B");
    assert_string_equal(f->scene->path, "room.gltf");
    double low[3], high[3];
    assert_false(hpr_scene_bounds(f->scene, low, high));
}

static void channels_need_names(void **state)
{
    fixture *f = *state;
    hpr_scene *other = f->scene;
    assert_refused(f, hpr_scene_create(f->ctx, NULL, 0, NULL, &other), HPR_ERR_ARG, TEXTS("0 channels"));
    assert_null(other);
    assert_refused(f, hpr_scene_create(f->ctx, NULL, 5, NULL, &other), HPR_ERR_ARG, TEXTS("5 channels"));
    assert_null(other);
    assert_int_equal(hpr_scene_create(f->ctx, NULL, 1, TEXTS("power"), &other), HPR_OK);
    assert_string_equal(other->channel_name[0], "power");
    assert_string_equal(other->path, "");
    hpr_scene_destroy(&other);
    assert_null(other);
    hpr_scene_destroy(&other);
}

static void a_material_is_copied(void **state)
{
    fixture *f = *state;
    const double lamp[3] = {17, 12, 4};
    char name[] = "wall";
    uint32_t index = 99;
    assert_int_equal(hpr_scene_add_material(f->scene, "first", grey, dark, false, NULL), HPR_OK);
    assert_int_equal(hpr_scene_add_material(f->scene, name, grey, lamp, true, &index), HPR_OK);
    name[0] = 'x';
    assert_int_equal(index, 1);
    assert_string_equal(f->scene->material[1].name, "wall");
    assert_true(f->scene->material[1].double_sided && !f->scene->material[0].double_sided);
    assert_memory_equal(f->scene->material_reflectance + 3, grey, sizeof grey);
    assert_memory_equal(f->scene->material_radiance + 3, lamp, sizeof lamp);
}

static void bad_reflectances_are_refused_by_name(void **state)
{
    fixture *f = *state;
    static const struct {
        double value;
        const char *text;
    } bad[] = {{1.5, "1.5"}, {-0.25, "-0.25"}, {NAN, "nan"}, {INFINITY, "inf"}, {1 + 1e-9, "reflectance 1"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const double rho[3] = {0.5, bad[i].value, 0.5};
        assert_refused(f, hpr_scene_add_material(f->scene, "plaster", rho, dark, false, NULL), HPR_ERR_FORMAT,
                       TEXTS("room.gltf", "plaster", "channel G", bad[i].text));
    }
    assert_int_equal(f->scene->material_count, 0);
}

static void bad_radiances_are_refused_by_name(void **state)
{
    fixture *f = *state;
    static const struct {
        double value;
        const char *text;
    } bad[] = {{-2, "-2"}, {NAN, "nan"}, {INFINITY, "inf"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        const double radiance[3] = {0, 0, bad[i].value};
        assert_refused(f, hpr_scene_add_material(f->scene, NULL, grey, radiance, false, NULL), HPR_ERR_FORMAT,
                       TEXTS("room.gltf", "(unnamed)", "channel B", "radiance", bad[i].text));
    }
    assert_int_equal(f->scene->material_count, 0);
}

static void one_is_a_reflectance_and_rounding_is_forgiven(void **state)
{
    fixture *f = *state;
    const double white[3] = {1, 1 + DBL_EPSILON, 0};
    assert_int_equal(hpr_scene_add_material(f->scene, "white", white, dark, false, NULL), HPR_OK);
    assert_true(f->scene->material_reflectance[0] == 1);
    assert_true(f->scene->material_reflectance[1] == 1);
}

static void a_mesh_is_copied(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    const double uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};
    const double rho[3] = {0.1, 0.2, 0.3};
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    mesh.uv = uv;
    mesh.face_reflectance = rho;
    mesh.vertex = (const uint32_t[]){2, 1, 0, HPR_NONE};
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    const hpr_scene *s = f->scene;
    assert_int_equal(s->mesh_count, 2);
    assert_int_equal(s->vertex_count, 8);
    assert_int_equal(s->face_count, 2);
    assert_string_equal(s->mesh_name[1], "square");
    assert_int_equal(s->mesh_node[1], 5);
    assert_int_equal(s->mesh_primitive[1], 7);
    assert_int_equal(s->face_mesh[1], 1);
    assert_memory_equal(s->face_vertex, ((const uint32_t[]){0, 1, 2, 3, 6, 5, 4, HPR_NONE}), 32);
    assert_memory_equal(s->position + 12, square, sizeof square);
    assert_true(isnan(s->uv[0]) && s->uv[8 + 2] == 1);
    assert_true(s->colour[0] == 1);
    assert_memory_equal(s->face_reflectance + 3, rho, sizeof rho);
}

static void reflectance_comes_from_face_or_material_or_default(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    const double rho[3] = {0, 0.5, 1};
    assert_int_equal(hpr_scene_add_material(f->scene, "grey", grey, dark, false, &mesh.material), HPR_OK);
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    mesh.face_reflectance = rho;
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    mesh = square_mesh();
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    const double expected[9] = {0.5, 0.25, 0.125, 0, 0.5, 1, 0.8, 0.8, 0.8};
    assert_memory_equal(f->scene->face_reflectance, expected, sizeof expected);
}

static void a_mesh_that_makes_no_sense_is_refused(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    mesh.material = 3;
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT,
                   TEXTS("room.gltf", "node 5", "primitive 7", "material 3"));
    double bent[12];
    memcpy(bent, square, sizeof bent);
    bent[7] = NAN;
    mesh = square_mesh();
    mesh.position = bent;
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT,
                   TEXTS("node 5", "vertex 2", "nan"));
    bent[7] = -INFINITY;
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT, TEXTS("vertex 2", "-inf"));
    mesh = square_mesh();
    mesh.vertex = (const uint32_t[]){0, 1, 4, 3};
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT,
                   TEXTS("face 0", "vertex 4", "4 vertices"));
    mesh.vertex = (const uint32_t[]){0, 1, HPR_NONE, 3}; /* only the fourth may be absent */
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT, TEXTS("face 0"));
    assert_int_equal(f->scene->mesh_count + f->scene->vertex_count + f->scene->face_count, 0);
}

static void a_face_that_reflects_too_much_names_its_material(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    assert_int_equal(hpr_scene_add_material(f->scene, "chalk", grey, dark, false, &mesh.material), HPR_OK);
    mesh.face_reflectance = (const double[]){0.5, 1.25, 0.5};
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT,
                   TEXTS("room.gltf", "chalk", "face 0", "1.25", "channel G"));
    mesh.face_reflectance = (const double[]){0.5, 0.5, NAN};
    assert_refused(f, hpr_scene_add_mesh(f->scene, &mesh), HPR_ERR_FORMAT,
                   TEXTS("chalk", "nan", "channel B"));
}

static void a_camera_is_copied(void **state)
{
    fixture *f = *state;
    hpr_camera camera = good_camera();
    assert_int_equal(hpr_scene_add_camera(f->scene, &camera), HPR_OK);
    camera.name = NULL;
    camera.kind = HPR_CAMERA_ORTHOGRAPHIC;
    camera.znear = 0;
    camera.zfar = 100;
    assert_int_equal(hpr_scene_add_camera(f->scene, &camera), HPR_OK);
    assert_int_equal(f->scene->camera_count, 2);
    assert_string_equal(f->scene->camera[0].name, "eye");
    assert_string_equal(f->scene->camera[1].name, "");
    assert_true(f->scene->camera[0].yfov_rad == 0.7 && f->scene->camera[1].ymag == 2);
}

/* One field of a good camera, set to something with which nothing can be seen. */
static hpr_camera bad_camera(int which)
{
    hpr_camera c = good_camera();
    switch (which) {
    case 0:
        c.yfov_rad = 0;
        break;
    case 1:
        c.yfov_rad = 3.2; /* more than π */
        break;
    case 2:
        c.yfov_rad = NAN;
        break;
    case 3:
        c.aspect = -1;
        break;
    case 4:
        c.origin[1] = INFINITY;
        break;
    case 5:
        c.backward[2] = NAN;
        break;
    case 6:
        c.znear = -0.1;
        break;
    case 7:
        c.zfar = c.znear;
        break;
    case 8:
        c.zfar = NAN;
        break;
    case 9:
        c.kind = HPR_CAMERA_ORTHOGRAPHIC;
        c.xmag = 0;
        break;
    default:
        c.kind = HPR_CAMERA_ORTHOGRAPHIC;
        c.ymag = INFINITY;
        break;
    }
    return c;
}

static void cameras_that_see_nothing_are_refused_by_name(void **state)
{
    fixture *f = *state;
    for (int which = 0; which <= 10; which++) {
        hpr_camera camera = bad_camera(which);
        hpr_status status = hpr_scene_add_camera(f->scene, &camera);
        if (status == HPR_OK)
            fail_msg("bad camera %d was accepted", which);
        assert_refused(f, status, HPR_ERR_FORMAT, TEXTS("room.gltf", "camera 0", "eye"));
    }
    assert_int_equal(f->scene->camera_count, 0);
}

static void reflectances_are_limited_in_proportion(void **state)
{
    fixture *f = *state;
    const double bright[3] = {1, 0.5, 0.25};
    hpr_mesh mesh = square_mesh();
    assert_int_equal(hpr_scene_add_material(f->scene, "grey", grey, dark, false, NULL), HPR_OK);
    assert_int_equal(hpr_scene_add_material(f->scene, "snow", bright, dark, false, &mesh.material), HPR_OK);
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, 0.5), HPR_OK);
    const double expected[6] = {0.5, 0.25, 0.125, 0.5, 0.25, 0.125};
    assert_memory_equal(f->scene->material_reflectance, expected, sizeof expected);
    assert_memory_equal(f->scene->face_reflectance, expected + 3, 3 * sizeof(double));
    assert_int_equal(f->warnings, 2); /* snow and its face; grey is left alone */
    assert_non_null(strstr(hpr_warning_text(f->ctx, 0), "snow"));
}

static void limiting_twice_changes_nothing(void **state)
{
    fixture *f = *state;
    enum { COUNT = 200 };
    const double limit = 0.35; /* rho * (limit / rho) rounds up for two of these */
    for (int i = 0; i < COUNT; i++) {
        double value = limit + (1 - limit) * (i + 0.5) / COUNT;
        const double rho[3] = {value, value / 3, value / 7};
        assert_int_equal(hpr_scene_add_material(f->scene, "m", rho, dark, false, NULL), HPR_OK);
    }
    double before[3 * COUNT];
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, limit), HPR_OK);
    memcpy(before, f->scene->material_reflectance, sizeof before);
    for (int i = 0; i < COUNT; i++) {
        if (before[3 * i] > limit)
            fail_msg("reflectance %.17g is still above the limit %.17g", before[3 * i], limit);
    }
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, limit), HPR_OK);
    assert_memory_equal(f->scene->material_reflectance, before, sizeof before);
}

static void limits_outside_zero_to_one_are_refused(void **state)
{
    fixture *f = *state;
    static const double bad[] = {0, -1, 1.5, NAN, INFINITY};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_refused(f, hpr_scene_limit_reflectance(f->scene, bad[i]), HPR_ERR_ARG, TEXTS("(0, 1]"));
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, 1), HPR_OK);
}

static void the_environment_is_dark_until_it_is_set(void **state)
{
    fixture *f = *state;
    const double sky[3] = {0.5, 3, 0}, one = 2, none[3] = {0}, all[3] = {2, 2, 2};
    assert_memory_equal(f->scene->environment, none, sizeof none);
    assert_int_equal(hpr_scene_set_environment(f->scene, 3, sky), HPR_OK);
    assert_memory_equal(f->scene->environment, sky, sizeof sky);
    assert_int_equal(hpr_scene_set_environment(f->scene, 1, &one), HPR_OK);
    assert_memory_equal(f->scene->environment, all, sizeof all);
}

static void a_bad_environment_is_refused(void **state)
{
    fixture *f = *state;
    const double good[3] = {1, 2, 3};
    const struct {
        size_t count;
        double radiance[4];
        const char *text;
    } bad[] = {{0, {0}, "0 radiances"}, {2, {1, 1}, "2 radiances"}, {4, {1, 1, 1, 1}, "4 radiances"},
               {1, {-1}, "-1"},         {3, {1, 1, NAN}, "nan"},    {3, {INFINITY, 1, 1}, "inf"}};
    assert_int_equal(hpr_scene_set_environment(f->scene, 3, good), HPR_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        assert_refused(f, hpr_scene_set_environment(f->scene, bad[i].count, bad[i].radiance), HPR_ERR_ARG,
                       TEXTS("room.gltf", bad[i].text));
        assert_memory_equal(f->scene->environment, good, sizeof good);
    }
}

static void bounds_are_those_of_the_faces(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    mesh.vertex = (const uint32_t[]){0, 1, 2, HPR_NONE}; /* vertex 3, at z = -2, is not used */
    double low[3], high[3];
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    assert_true(hpr_scene_bounds(f->scene, low, high));
    assert_memory_equal(low, ((const double[]){0, 0, 0}), sizeof low);
    assert_memory_equal(high, ((const double[]){1, 1, 0}), sizeof high);
    mesh.vertex = quad;
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    assert_true(hpr_scene_bounds(f->scene, low, high));
    assert_true(low[2] == -2);
}

static void many_things_fit(void **state)
{
    fixture *f = *state;
    enum { COUNT = 300 }; /* several doublings of every array */
    for (uint32_t i = 0; i < COUNT; i++) {
        hpr_mesh mesh = square_mesh();
        const double rho[3] = {i / 1000.0, 0, 0};
        char name[16];
        snprintf(name, sizeof name, "m%u", i);
        mesh.node = i;
        assert_int_equal(hpr_scene_add_material(f->scene, name, rho, dark, false, &mesh.material), HPR_OK);
        assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
        hpr_camera camera = good_camera();
        camera.origin[0] = i;
        assert_int_equal(hpr_scene_add_camera(f->scene, &camera), HPR_OK);
    }
    const hpr_scene *s = f->scene;
    assert_int_equal(s->vertex_count, 4 * COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_int_equal(strtol(s->material[i].name + 1, NULL, 10), i);
        assert_int_equal(s->mesh_node[i], i);
        assert_int_equal(s->mesh_material[i], i);
        assert_int_equal(s->face_mesh[i], i);
        assert_int_equal(s->face_vertex[4 * i], 4 * i);
        assert_true(s->face_reflectance[3 * i] == i / 1000.0);
        assert_true(s->position[12 * i + 11] == -2);
        assert_true(s->camera[i].origin[0] == i);
    }
}

/* A scene with some of everything, enough for each array to grow once more than it begins with. */
static hpr_status build_scene(hpr_context *ctx, void *data)
{
    (void)data;
    hpr_scene *scene = NULL;
    hpr_status status = hpr_scene_create(ctx, "room.gltf", 2, TEXTS("a", "b"), &scene);
    uint32_t texture = 0;
    if (status == HPR_OK)
        status = hpr_scene_add_texture(
            scene, &(hpr_texture){.width = 1, .height = 1, .texel = (float[]){1, 0}}, &texture);
    for (int i = 0; status == HPR_OK && i < 20; i++) {
        hpr_mesh mesh = square_mesh();
        mesh.factor = grey;
        mesh.texture = texture;
        status = hpr_scene_add_material(scene, "m", grey, dark, false, &mesh.material);
        if (status == HPR_OK)
            status = hpr_scene_add_mesh(scene, &mesh);
        hpr_camera camera = good_camera();
        if (status == HPR_OK)
            status = hpr_scene_add_camera(scene, &camera);
    }
    hpr_scene_destroy(&scene);
    return status;
}

static void a_scene_survives_without_memory(void **state)
{
    (void)state;
    size_t allocations = sweep_allocations(build_scene, NULL, 1);
    /* context, scene, path, environment, channel names 1 + 2; a texture and its texels; 60 names; 3 + 8 + 4 +
     * 1 arrays that grow twice, and 4 of vertices (80 of them) that grow four times: 16, 32, 64, 128 */
    assert_int_equal(allocations, 7 + 2 + 60 + 2 * 16 + 4 * 4);
}

static void a_refused_mesh_leaves_the_scene_as_it_was(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    for (size_t k = 0;; k++) {
        size_t meshes = f->scene->mesh_count, vertices = f->scene->vertex_count, faces = f->scene->face_count;
        f->allocator.failed = false;
        f->allocator.fail_at = f->allocator.calls + k;
        hpr_status status = hpr_scene_add_mesh(f->scene, &mesh);
        f->allocator.fail_at = SIZE_MAX;
        if (!f->allocator.failed)
            break;
        assert_int_equal(status, HPR_ERR_MEMORY);
        assert_int_equal(f->scene->mesh_count, meshes);
        assert_int_equal(f->scene->vertex_count, vertices);
        assert_int_equal(f->scene->face_count, faces);
    }
    hpr_context_clear_error(f->ctx);
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    assert_int_equal(f->scene->mesh_count, 2);
    assert_memory_equal(f->scene->position + 12, square, sizeof square);
}

/* Rows 0, 0.5 and 1, 0.25: what (u,v) shows in every wrap mode, between texel centres or not. */
static void a_texture_is_sampled_as_its_sampler_says(void **state)
{
    (void)state;
    float texel[] = {0, 0.5F, 1, 0.25F};
    static const struct {
        hpr_wrap wrap;
        uint8_t nearest;
        double u, v, value;
    } cases[] = {
        {HPR_WRAP_REPEAT, 1, 0.3, 0.3, 0},      {HPR_WRAP_REPEAT, 1, -0.3, 0.3, 0.5},
        {HPR_WRAP_MIRROR, 1, -0.3, 0.3, 0},     {HPR_WRAP_CLAMP, 1, 7.3, 0.9, 0.25},
        {HPR_WRAP_REPEAT, 1, 1e15, 0.6, 1},     {HPR_WRAP_REPEAT, 0, 0.25, 0.25, 0},
        {HPR_WRAP_REPEAT, 0, 0.5, 0.5, 0.4375}, {HPR_WRAP_REPEAT, 0, 0, 0.25, 0.25},
        {HPR_WRAP_MIRROR, 0, 0, 0.25, 0},       {HPR_WRAP_CLAMP, 0, -1, 0.75, 1},
        {HPR_WRAP_CLAMP, 0, 0.375, 2, 0.8125},  {HPR_WRAP_MIRROR, 0, 1.75, 0.75, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        uint8_t wrap = (uint8_t)cases[i].wrap;
        const hpr_texture t = {2, 2, {wrap, wrap}, cases[i].nearest, texel};
        double value;
        hpr_texture_sample(&t, 1, cases[i].u, cases[i].v, &value);
        if (value != cases[i].value)
            fail_msg("case %zu: %.17g, expected %.17g", i, value, cases[i].value);
    }
}

/* Means and factor keep their ratio; a mesh whose whitest point is below the limit stays as it is. */
static void a_texture_is_limited_as_a_whole(void **state)
{
    fixture *f = *state;
    hpr_mesh mesh = square_mesh();
    const double factor[3] = {1, 0.5, 0.5}, mean[3] = {0.4, 0.2, 0.2};
    float texel[6] = {0, 0, 0, 0.8F, 0.8F, 0.8F};
    const hpr_texture texture = {.width = 2, .height = 1, .texel = texel};
    mesh.factor = factor;
    mesh.face_reflectance = mean;
    assert_int_equal(hpr_scene_add_texture(f->scene, &texture, &mesh.texture), HPR_OK);
    assert_int_equal(hpr_scene_add_mesh(f->scene, &mesh), HPR_OK);
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, 0.9), HPR_OK);
    assert_true(f->scene->mesh_factor[0] == 1 && f->scene->face_reflectance[0] == 0.4);
    assert_int_equal(hpr_scene_limit_reflectance(f->scene, 0.4), HPR_OK);
    assert_true(fabs(f->scene->mesh_factor[0] - 0.5) < 1e-7); /* 0.8 is a float */
    assert_true(fabs(f->scene->mesh_factor[2] - 0.25) < 1e-7);
    assert_true(fabs(f->scene->face_reflectance[0] - 0.2) < 1e-7);
}

#define SCENE_TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        SCENE_TEST(an_empty_scene_has_three_channels),
        SCENE_TEST(channels_need_names),
        SCENE_TEST(a_material_is_copied),
        SCENE_TEST(bad_reflectances_are_refused_by_name),
        SCENE_TEST(bad_radiances_are_refused_by_name),
        SCENE_TEST(one_is_a_reflectance_and_rounding_is_forgiven),
        SCENE_TEST(a_mesh_is_copied),
        SCENE_TEST(reflectance_comes_from_face_or_material_or_default),
        SCENE_TEST(a_mesh_that_makes_no_sense_is_refused),
        SCENE_TEST(a_face_that_reflects_too_much_names_its_material),
        SCENE_TEST(a_camera_is_copied),
        SCENE_TEST(cameras_that_see_nothing_are_refused_by_name),
        SCENE_TEST(reflectances_are_limited_in_proportion),
        SCENE_TEST(limiting_twice_changes_nothing),
        SCENE_TEST(limits_outside_zero_to_one_are_refused),
        SCENE_TEST(the_environment_is_dark_until_it_is_set),
        SCENE_TEST(a_bad_environment_is_refused),
        SCENE_TEST(bounds_are_those_of_the_faces),
        SCENE_TEST(many_things_fit),
        cmocka_unit_test(a_texture_is_sampled_as_its_sampler_says),
        SCENE_TEST(a_texture_is_limited_as_a_whole),
        SCENE_TEST(a_refused_mesh_leaves_the_scene_as_it_was),
        cmocka_unit_test(a_scene_survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
