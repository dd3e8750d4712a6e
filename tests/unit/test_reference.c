/* Path tracing: what holds exactly, for every path. What holds in the mean is in
 * convergence/test_reference.c. */
#include "failing_allocator.h"

#include "baseline/lights.h"
#include "baseline/random.h"
#include "traced.h"

#include <string.h>

#define PI 3.14159265358979323846

/* Known answers of the authors' Random123 (kat_vectors, philox4x64 10). */
static void philox_gives_the_known_answers(void **state)
{
    (void)state;
    static const uint64_t ones = UINT64_MAX;
    static const uint64_t cases[3][10] = {
        {0, 0, 0, 0, 0, 0, 0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b},
        {ones, ones, ones, ones, ones, ones, 0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6,
         0xa09caebf594f0ba0},
        {0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89, 0x452821e638d01377,
         0xbe5466cf34e90c6c, 0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}};
    for (int i = 0; i < 3; i++) {
        uint64_t word[HPR_PHILOX_WORDS];
        hpr_philox(cases[i], cases[i] + 4, word);
        assert_memory_equal(word, cases[i] + 6, sizeof word);
    }
}

/* Seed, picture, pixel and sample each lead to other numbers, and so does every step. */
static void every_path_has_numbers_of_its_own(void **state)
{
    (void)state;
    enum { STREAMS = 16, NUMBERS = 9, COUNT = STREAMS * NUMBERS };
    double number[COUNT];
    for (unsigned i = 0; i < STREAMS; i++) {
        hpr_random random = hpr_random_of(i & 1, i >> 1 & 1, i >> 2 & 1, i >> 3 & 1);
        for (int k = 0; k < NUMBERS; k++) {
            double x = number[NUMBERS * i + (unsigned)k] = hpr_random_unit(&random);
            assert_true(x >= 0 && x < 1);
        }
    }
    for (int i = 0; i < COUNT; i++) {
        for (int k = 0; k < i; k++)
            assert_true(number[i] != number[k]);
    }
}

/* Powers 1 : 2 : 5 (areas 1, 2, 1, strongest channels 1, 1, 5), one of them doubleSided, and a dark face. */
static hpr_room room_of_lamps(void)
{
    const double a[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double b[4][3] = {{2, 0, 0}, {4, 0, 0}, {4, 1, 0}, {2, 1, 0}};
    const double c[3][3] = {{5, 0, 0}, {7, 0, 0}, {5, 1, 0}};
    const double dark[4][3] = {{8, 0, 0}, {9, 0, 0}, {9, 1, 0}, {8, 1, 0}};
    hpr_room room = room_open(1);
    room_add(&room, 4, a, 0, 1, false);
    room_add(&room, 4, dark, 0, 0, true);
    room_add(&room, 4, b, 0, 1, true);
    room_add(&room, 3, c, 0, 5, false);
    return room;
}

/* u in steps of 1/800: each lamp has its share of them, the boundaries may fall to either side. */
static void lamps_are_chosen_by_their_power(void **state)
{
    (void)state;
    hpr_room room = room_of_lamps();
    hpr_patches *patches = NULL;
    hpr_lights lights;
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_lights_init(patches, &lights), HPR_OK);
    assert_int_equal(lights.count, 3);
    int chosen[6] = {0};
    static const int expected[6] = {100, 0, 0, 200, 0, 500};
    for (int i = 0; i < 800; i++) {
        const double from[3] = {0, 0, 1};
        double y[3];
        chosen[hpr_lights_choose(&lights, from, i / 800.0, 0.25, 0.5, y)]++;
    }
    for (int i = 0; i < 6; i++) {
        double density = expected[i ? i == 4 ? 3 : i : 0] / 800.0 / patches->area_m2[i];
        print_message("patch %d: chosen %d times of 800, expected %d; density %.6g, expected %.6g\n", i,
                      chosen[i], expected[i], lights.density[i], density);
        assert_true(abs(chosen[i] - expected[i]) <= 1);
        assert_true(fabs(lights.density[i] - density) <= 1e-15);
    }
    hpr_lights_fini(&lights);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/* From behind a doubleSided lamp, its back; the point is on the lamp. */
static void the_side_that_faces_is_chosen(void **state)
{
    (void)state;
    hpr_room room = room_of_lamps();
    hpr_patches *patches = NULL;
    hpr_lights lights;
    double y[3];
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_lights_init(patches, &lights), HPR_OK);
    assert_int_equal(hpr_lights_choose(&lights, (double[]){3, 0, 1}, 0.3, 0.25, 0.5, y), 3);
    assert_true(y[0] == 2.5 && y[1] == 0.5 && y[2] == 0);
    assert_int_equal(hpr_lights_choose(&lights, (double[]){3, 0, -1}, 0.3, 0.25, 0.5, y), 4);
    /* Beyond the diagonal of a triangle the parameters are folded back into it. */
    assert_int_equal(hpr_lights_choose(&lights, (double[]){5, 0, -1}, 0.9, 0.75, 0.5, y), 5);
    assert_true(y[0] == 5.5 && y[1] == 0.5);
    hpr_lights_fini(&lights);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/* A black room: only what the camera sees directly, M / pi, once. */
static void a_lamp_in_view_counts_once(void **state)
{
    (void)state;
    const double rho[6] = {0}, m[6] = {3, 3, 3, 3, 3, 3};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    traced_look_along_x(&room, 0.25, 0.5, 0.5);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 8});
    for (size_t i = 0; i < 192; i++) {
        assert_true(image.radiance[i] == (float)(3 / PI) && image.variance[i] == 0);
        assert_true(image.coverage[i / 3] == 1);
    }
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* A floor, a lamp aside that faces down, and above the floor a panel that faces up. */
static hpr_image panel(double reflectance, double exitance, bool double_sided, double lamp_exitance)
{
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double lamp[4][3] = {{1, 0, 1}, {1, 1, 1}, {2, 1, 1}, {2, 0, 1}};
    const double back[4][3] = {{0, 0, 0.5}, {0.8, 0, 0.5}, {0.8, 1, 0.5}, {0, 1, 0.5}};
    hpr_room room = room_open(1);
    room_add(&room, 4, floor, 0.5, 0, false);
    room_add(&room, 4, lamp, 0, lamp_exitance, false);
    room_add(&room, 4, back, reflectance, exitance, double_sided);
    traced_look_down(&room, 0.5, 0.5, 0.25, 0.5);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 8});
    room_close(&room);
    return image;
}

static bool same_picture(const hpr_image *a, const hpr_image *b)
{
    size_t pixels = (size_t)a->width * (size_t)a->height, bytes = pixels * a->channel_count * sizeof(float);
    return a->width == b->width && a->height == b->height && !memcmp(a->radiance, b->radiance, bytes) &&
           !memcmp(a->variance, b->variance, bytes) &&
           !memcmp(a->coverage, b->coverage, pixels * sizeof(float));
}

/* Of a picture that outlives its context, whose memory was the C library's. */
static void discard(hpr_image *image)
{
    free(image->radiance);
    free(image->coverage);
    free(image->variance);
}

static void backs_do_not_reflect(void **state)
{
    (void)state;
    hpr_image black = panel(0, 0, false, 1), white = panel(1, 0, false, 1), both = panel(1, 0, true, 1);
    assert_true(traced_mean(&black).mean > 0);
    assert_true(same_picture(&black, &white));
    assert_true(traced_mean(&both).mean > 1.02 * traced_mean(&white).mean);
    discard(&black);
    discard(&white);
    discard(&both);
}

static void backs_do_not_shine(void **state)
{
    (void)state;
    hpr_image single = panel(0, 1, false, 0), both = panel(0, 1, true, 0);
    for (size_t i = 0; i < 192; i++)
        assert_true(single.radiance[i] == 0 && both.radiance[i] > 0);
    discard(&single);
    discard(&both);
}

/* The camera looks through the back of the ceiling; what it hides is not covered. */
static void backs_are_culled_for_the_camera(void **state)
{
    (void)state;
    const double rho[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, m[6] = {0, 0, 0, 0, 1, 0};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    traced_look_down(&room, 0, 0.5, 3, 0.125); /* the left half of the picture misses the room */
    hpr_image image = traced(&room, 0, (traced_setting){.side = 2, .samples = 64});
    for (size_t i = 0; i < 4; i++) {
        assert_true(image.coverage[i] == (float)(i % 2));
        assert_true(i % 2 ? image.radiance[3 * i] > (float)(1 / PI) : image.radiance[3 * i] == 0);
    }
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* Where everything is white, every path ends outside and brings what it finds there: L everywhere, no noise.
 */
static void the_environment_reaches_every_white_surface(void **state)
{
    (void)state;
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double wall[4][3] = {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}};
    hpr_room room = room_open(1);
    room_add(&room, 4, floor, 1, 0, true);
    room_add(&room, 4, wall, 1, 0, true);
    traced_look_down(&room, 0.5, 0.5, 2, 1);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 16, .samples = 16, .environment = 2});
    size_t seen = 0;
    for (size_t i = 0; i < 256; i++) {
        seen += image.coverage[i] == 1;
        assert_true(fabsf(image.radiance[3 * i] - 2) <= 4 * 1.2e-7f); /* float32, and a few roundings */
    }
    assert_int_equal(seen, 64); /* the rest is sky: radiance 2 as well, and no coverage */
    assert_true(image.coverage[0] == 0);
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* One number for each channel; an open floor of rho 1/2 sends back half of it. */
static void the_environment_has_channels(void **state)
{
    (void)state;
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, sky[3] = {1, 0, 4};
    const hpr_render_options film = {4, 4, 4};
    hpr_room room = room_open(1);
    hpr_reference *reference = NULL;
    hpr_image image;
    room_add(&room, 4, floor, 0.5, 0, false);
    traced_look_down(&room, 0.5, 0.5, 2, 0.5);
    assert_int_equal(hpr_scene_set_environment(room.scene, 3, sky), HPR_OK);
    assert_int_equal(hpr_reference_create(room.context, room.scene, NULL, &reference), HPR_OK);
    assert_int_equal(hpr_reference_render(room.context, reference, 0, &film, &image), HPR_OK);
    for (size_t i = 0; i < 48; i++)
        assert_true(fabs((double)image.radiance[i] - 0.5 * sky[i % 3]) <= 4 * 1.2e-7 * sky[i % 3]);
    hpr_image_fini(room.context, &image);
    hpr_reference_destroy(&reference);
    room_close(&room);
}

/* A closed room in a bright world: what is inside stays dark. 400 000 reflections, so that a gap of a
 * millionth of the size along the edges would be found. */
static void closed_rooms_are_tight(void **state)
{
    (void)state;
    const double rho[6] = {0.9, 0.9, 0.9, 0.9, 0.9, 0.9}, m[6] = {0};
    hpr_room room = room_open(2);
    room_add_box(&room, 1.0 / 3, 0.7, 1.1, rho, m, -1);
    traced_look_along_x(&room, 0.1, 0.3, 0.4);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 36, .samples = 32, .environment = 1});
    for (size_t i = 0; i < 36 * 36; i++)
        assert_true(image.radiance[3 * i] == 0 && image.coverage[i] == 1);
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

/* Green is reflected wholly and has no lamp: it must not keep paths alive. */
static void dark_channels_end(void **state)
{
    (void)state;
    const double rho[3] = {0.5, 1, 0.5}, red[3] = {1, 0, 0};
    const double corner[3] = {0}, axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    hpr_room room = room_open(1);
    hpr_image image;
    traced_add_cube(&room, corner, axis, rho, red);
    traced_look_along_x(&room, 0.25, 0.5, 0.5);
    assert_int_equal(traced_try(&room, 0, (traced_setting){.side = 4, .samples = 16}, &image), HPR_OK);
    assert_true(image.radiance[0] > 1 && image.radiance[1] == 0);
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

static void cameras_have_noise_of_their_own(void **state)
{
    (void)state;
    const double rho[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, m[6] = {0, 0, 0, 0, 0, 1};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    for (int i = 0; i < 2; i++)
        traced_look_along_x(&room, 0.25, 0.5, 0.5);
    hpr_image one = traced(&room, 0, (traced_setting){.side = 4, .samples = 4});
    hpr_image two = traced(&room, 1, (traced_setting){.side = 4, .samples = 4});
    for (size_t i = 0; i < 16; i++)
        assert_true(one.radiance[3 * i] != two.radiance[3 * i]);
    hpr_image_fini(room.context, &one);
    hpr_image_fini(room.context, &two);
    room_close(&room);
}

static void no_finite_solution_is_said(void **state)
{
    (void)state;
    const double rho[6] = {1, 1, 1, 1, 1, 1}, m[6] = {0, 0, 0, 0, 0, 1};
    hpr_room room = room_open(1);
    hpr_image image;
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    traced_look_along_x(&room, 0.25, 0.5, 0.5);
    assert_int_equal(traced_try(&room, 0, (traced_setting){.side = 4, .samples = 4}, &image),
                     HPR_ERR_NUMERIC);
    assert_non_null(strstr(hpr_context_error(room.context), "--max-reflectance"));
    assert_null(image.radiance);
    assert_int_equal(hpr_scene_limit_reflectance(room.scene, 0.9), HPR_OK);
    assert_int_equal(traced_try(&room, 0, (traced_setting){.side = 4, .samples = 4}, &image), HPR_OK);
    hpr_image_fini(room.context, &image);
    room_close(&room);
}

static void no_light_and_no_surface_are_warnings(void **state)
{
    (void)state;
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int surfaces = 0; surfaces < 2; surfaces++) {
        hpr_room room = room_open(1);
        if (surfaces)
            room_add(&room, 4, floor, 1, 0, false);
        hpr_image image = traced(&room, 0, (traced_setting){.side = 8, .samples = 4});
        assert_int_equal(hpr_warning_count(room.context), 1);
        assert_non_null(strstr(hpr_warning_text(room.context, 0), surfaces ? "no light" : "no surface"));
        float covered = 0;
        for (size_t i = 0; i < 64; i++) {
            assert_true(image.radiance[3 * i] == 0 && image.variance[3 * i] == 0);
            covered += image.coverage[i];
        }
        assert_true((covered > 0) == surfaces); /* a scene without camera is framed */
        hpr_image_fini(room.context, &image);
        room_close(&room);
    }
}

static hpr_image mixed_room(int threads)
{
    const double rho[6] = {0.2, 0.7, 0.5, 0.5, 0.8, 0.6}, m[6] = {0, 0, 0, 1, 0, 1};
    const double table[4][3] = {{0.2, 0.2, 0.4}, {0.8, 0.2, 0.4}, {0.8, 0.8, 0.4}, {0.2, 0.8, 0.4}};
    hpr_room room = room_open(threads);
    room_add_box(&room, 1, 1, 1, rho, m, 0);
    room_add(&room, 4, table, 0.5, 0.1, true);
    traced_look_along_x(&room, -0.5, 0.5, 0.5);
    hpr_image image = traced(&room, 0, (traced_setting){.side = 24, .samples = 8, .environment = 0.1});
    room_close(&room);
    return image;
}

static void threads_give_the_same_bits(void **state)
{
    (void)state;
    static const int threads[] = {2, 7};
    hpr_image one = mixed_room(1);
    assert_true(traced_mean(&one).mean > 0);
    for (int i = 0; i < 2; i++) {
        hpr_image many = mixed_room(threads[i]);
        assert_true(same_picture(&one, &many));
        discard(&many);
    }
    discard(&one);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const hpr_render_options bad[] = {{4, 4, 1},  {4, 4, 0},    {4, 4, -2}, {4, 4, HPR_MAX_PATHS + 1},
                                      {-1, 4, 2}, {4, 40000, 2}};
    hpr_room room = room_open(1);
    hpr_reference *reference = NULL;
    room_add(&room, 4, floor, 1, 1, false);
    assert_int_equal(hpr_reference_create(room.context, room.scene, NULL, &reference), HPR_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hpr_image image;
        assert_int_equal(hpr_reference_render(room.context, reference, 0, &bad[i], &image), HPR_ERR_ARG);
        assert_null(image.radiance);
        assert_true(hpr_context_error(room.context)[0] != '\0');
    }
    hpr_image image;
    assert_int_equal(hpr_reference_camera_count(reference), 1);
    assert_string_equal(hpr_reference_camera_name(reference, 0), "");
    assert_int_equal(hpr_reference_render(room.context, reference, 1, NULL, &image), HPR_ERR_ARG);
    hpr_reference_destroy(&reference);
    hpr_reference_destroy(&reference);
    room_close(&room);
}

typedef struct watch {
    volatile sig_atomic_t cancel;
    double last, cancel_at;
    bool fell;
} watch;

static void on_progress(void *user, const char *stage, double fraction)
{
    watch *w = user;
    if (strcmp(stage, "trace"))
        return;
    w->fell = w->fell || fraction < w->last;
    w->last = fraction;
    if (fraction >= w->cancel_at)
        w->cancel = 1;
}

static void progress_rises_and_cancelling_works(void **state)
{
    (void)state;
    const double floor[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (int cancels = 0; cancels < 2; cancels++) {
        watch w = {.cancel_at = cancels ? 0.3 : 2};
        hpr_context_options options;
        hpr_context_options_init(&options);
        options.threads = 2;
        options.progress = on_progress;
        options.user = &w;
        options.cancel = &w.cancel;
        hpr_room room = {0};
        hpr_image image;
        assert_int_equal(hpr_context_create(&options, &room.context), HPR_OK);
        assert_int_equal(hpr_scene_create(room.context, "room", 3, NULL, &room.scene), HPR_OK);
        room_add(&room, 4, floor, 1, 1, false);
        hpr_status status = traced_try(&room, 0, (traced_setting){.side = 64, .samples = 2}, &image);
        assert_int_equal(status, cancels ? HPR_ERR_INTERRUPTED : HPR_OK);
        assert_true(cancels == (image.radiance == NULL));
        assert_true(!w.fell && w.last == 1);
        hpr_image_fini(room.context, &image);
        room_close(&room);
    }
}

static hpr_status trace_floor(hpr_context *ctx, void *data)
{
    static const double position[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, value[3] = {0.5, 0.5, 0.5};
    static const uint32_t vertex[4] = {0, 1, 2, 3};
    hpr_room room = {.context = ctx};
    hpr_image image = {0};
    uint32_t material;
    (void)data;
    hpr_status status = hpr_scene_create(ctx, "room", 3, NULL, &room.scene);
    if (status == HPR_OK)
        status = hpr_scene_add_material(room.scene, "face", value, value, true, &material);
    if (status == HPR_OK) {
        const hpr_mesh mesh = {
            .vertex_count = 4, .position = position, .face_count = 1, .vertex = vertex, .material = material};
        status = hpr_scene_add_mesh(room.scene, &mesh);
    }
    if (status == HPR_OK)
        status = traced_try(&room, 0, (traced_setting){.side = 2, .samples = 2}, &image);
    hpr_image_fini(ctx, &image);
    hpr_scene_destroy(&room.scene);
    return status;
}

static void memory_may_run_out_anywhere(void **state)
{
    (void)state;
    print_message("%zu allocations\n", sweep_allocations(trace_floor, NULL, 2));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(philox_gives_the_known_answers),
        cmocka_unit_test(every_path_has_numbers_of_its_own),
        cmocka_unit_test(lamps_are_chosen_by_their_power),
        cmocka_unit_test(the_side_that_faces_is_chosen),
        cmocka_unit_test(a_lamp_in_view_counts_once),
        cmocka_unit_test(backs_do_not_reflect),
        cmocka_unit_test(backs_do_not_shine),
        cmocka_unit_test(backs_are_culled_for_the_camera),
        cmocka_unit_test(the_environment_reaches_every_white_surface),
        cmocka_unit_test(the_environment_has_channels),
        cmocka_unit_test(closed_rooms_are_tight),
        cmocka_unit_test(dark_channels_end),
        cmocka_unit_test(cameras_have_noise_of_their_own),
        cmocka_unit_test(no_finite_solution_is_said),
        cmocka_unit_test(no_light_and_no_surface_are_warnings),
        cmocka_unit_test(threads_give_the_same_bits),
        cmocka_unit_test(bad_arguments_are_refused),
        cmocka_unit_test(progress_rises_and_cancelling_works),
        cmocka_unit_test(memory_may_run_out_anywhere),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
