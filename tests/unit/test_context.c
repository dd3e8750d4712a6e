#include "base/context.h"
#include "failing_allocator.h"

#include <limits.h>
#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

/* What the callbacks of a context were told. */
typedef struct record {
    failing_allocator allocator; /* first: the same `user` serves both */
    int warnings, infos, progress_calls;
    char text[2048];
    char stage[64];
    double fraction;
} record;

static void log_record(void *user, hpr_log_level level, const char *text)
{
    record *r = user;
    *(level == HPR_LOG_WARNING ? &r->warnings : &r->infos) += 1;
    snprintf(r->text, sizeof r->text, "%s", text);
}

static void progress_record(void *user, const char *stage, double fraction)
{
    record *r = user;
    r->progress_calls++;
    snprintf(r->stage, sizeof r->stage, "%s", stage);
    r->fraction = fraction;
}

static hpr_context *make_context(record *r)
{
    *r = (record){.allocator = FAILING_ALLOCATOR_INIT};
    hpr_context_options options = failing_options(&r->allocator);
    options.log = log_record;
    options.progress = progress_record;
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    return ctx;
}

static void finish(hpr_context *ctx, record *r)
{
    hpr_context_destroy(&ctx);
    assert_null(ctx);
    assert_int_equal(r->allocator.live, 0);
}

static void a_context_without_options_works(void **state)
{
    (void)state;
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_string_equal(hpr_context_error(ctx), "");
    hpr_warn(ctx, "nobody listens");
    hpr_info(ctx, "nobody listens");
    hpr_stage_begin(ctx, "nobody watches");
    hpr_stage_end(ctx);
    hpr_context_destroy(&ctx);
    assert_null(ctx);
    hpr_context_destroy(&ctx); /* NULL is accepted */
}

static hpr_status do_nothing(hpr_context *ctx, void *data)
{
    (void)ctx;
    (void)data;
    return HPR_OK;
}

static void create_survives_without_memory(void **state)
{
    (void)state;
    assert_int_equal(sweep_allocations(do_nothing, NULL, 0), 1);
}

static void half_an_allocator_is_refused(void **state)
{
    (void)state;
    hpr_context *ctx;
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.release = NULL;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_ERR_ARG);
    assert_null(ctx);
    hpr_context_options_init(&options);
    options.allocate = NULL;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_ERR_ARG);
    options = (hpr_context_options){0}; /* neither: the default */
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    hpr_context_destroy(&ctx);
}

static void the_first_error_wins(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    assert_int_equal(hpr_fail(ctx, HPR_ERR_IO, "file %d", 1), HPR_ERR_IO);
    assert_int_equal(hpr_fail(ctx, HPR_ERR_MEMORY, "file %d", 2), HPR_ERR_MEMORY);
    assert_string_equal(hpr_context_error(ctx), "file 1");
    finish(ctx, &r);
}

static void a_cleared_error_makes_room(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    hpr_fail(ctx, HPR_ERR_IO, "old");
    hpr_context_clear_error(ctx);
    assert_string_equal(hpr_context_error(ctx), "");
    hpr_fail(ctx, HPR_ERR_IO, "new");
    assert_string_equal(hpr_context_error(ctx), "new");
    finish(ctx, &r);
}

static void a_long_error_is_cut(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    hpr_fail(ctx, HPR_ERR_IO, "%05000d", 7);
    assert_in_range(strlen(hpr_context_error(ctx)), 500, 5000);
    finish(ctx, &r);
}

static void a_warning_is_said_once(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    for (int i = 0; i < 100; i++) /* 40 texts: the list grows past its first 16 */
        hpr_warn(ctx, "warning %d", i % 40);
    assert_int_equal(r.warnings, 40);
    assert_int_equal(hpr_warning_count(ctx), 40);
    assert_string_equal(hpr_warning_text(ctx, 0), "warning 0");
    assert_string_equal(hpr_warning_text(ctx, 39), "warning 39");
    finish(ctx, &r);
}

static void an_info_is_said_every_time(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    hpr_info(ctx, "info");
    hpr_info(ctx, "info");
    assert_int_equal(r.infos, 2);
    assert_int_equal(hpr_warning_count(ctx), 0);
    finish(ctx, &r);
}

static void a_warning_without_memory_is_still_said(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    for (size_t k = 0; k < 2; k++) { /* the list, then the text */
        r.allocator.fail_at = r.allocator.calls + k;
        hpr_warn(ctx, "warning %zu", k);
        assert_true(r.allocator.failed);
        assert_int_equal(r.warnings, k + 1);
        assert_int_equal(hpr_warning_count(ctx), 0);
        r.allocator.failed = false;
    }
    finish(ctx, &r);
}

enum { WORKERS = 4, ROUNDS = 20000 };

static void *count_a_lot(void *data)
{
    hpr_context *ctx = data;
    for (int i = 0; i < ROUNDS; i++) {
        hpr_count(ctx, HPR_COUNT_RAYS, 3);
        hpr_count(ctx, HPR_COUNT_KERNEL, UINT64_C(1) << 32);
        if (i % 1000 == 0)
            hpr_warn(ctx, "warning %d", i / 1000);
    }
    hpr_fail(ctx, HPR_ERR_NUMERIC, "a worker's error");
    return NULL;
}

static void threads_share_a_context(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    pthread_t worker[WORKERS];
    for (int i = 0; i < WORKERS; i++)
        assert_int_equal(pthread_create(&worker[i], NULL, count_a_lot, ctx), 0);
    for (int i = 0; i < WORKERS; i++)
        pthread_join(worker[i], NULL);
    assert_int_equal(hpr_counter_value(ctx, HPR_COUNT_RAYS), 3 * WORKERS * ROUNDS);
    assert_true(hpr_counter_value(ctx, HPR_COUNT_KERNEL) == (uint64_t)WORKERS * ROUNDS << 32);
    assert_int_equal(hpr_counter_value(ctx, HPR_COUNT_BLOCKS), 0);
    assert_int_equal(r.warnings, ROUNDS / 1000);
    assert_string_equal(hpr_context_error(ctx), "a worker's error");
    finish(ctx, &r);
}

static void work(double seconds)
{
    struct timespec start, now;
    clock_gettime(CLOCK_MONOTONIC, &start);
    do
        clock_gettime(CLOCK_MONOTONIC, &now);
    while ((double)(now.tv_sec - start.tv_sec) + 1e-9 * (double)(now.tv_nsec - start.tv_nsec) < seconds);
}

static void stage_times_add_up(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    for (int i = 0; i < 3; i++) {
        hpr_stage_begin(ctx, "first");
        work(0.01);
        hpr_stage_end(ctx);
        hpr_stage_begin(ctx, "second");
        hpr_stage_end(ctx);
    }
    hpr_stage_time times[HPR_MAX_STAGES];
    assert_int_equal(hpr_stage_times(ctx, times), 2);
    assert_string_equal(times[0].name, "first");
    assert_string_equal(times[1].name, "second");
    if (!(times[0].wall_s >= 0.03)) /* three stages that each waited 0.01 s on the same clock */
        fail_msg("three stages of 0.01 s took %g s", times[0].wall_s);
    if (!(times[0].cpu_s >= 0 && times[1].wall_s >= 0))
        fail_msg("negative times: %g s CPU, %g s", times[0].cpu_s, times[1].wall_s);
    finish(ctx, &r);
}

static void progress_names_the_running_stage(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    hpr_stage_progress(ctx, 0.5); /* no stage: nobody is told */
    hpr_stage_end(ctx);
    assert_int_equal(r.progress_calls, 0);
    hpr_stage_begin(ctx, "assembly");
    assert_string_equal(r.stage, "assembly");
    assert_true(r.fraction == 0);
    hpr_stage_progress(ctx, 0.25);
    assert_true(r.fraction == 0.25);
    hpr_stage_end(ctx);
    assert_true(r.fraction == 1);
    assert_int_equal(r.progress_calls, 3);
    finish(ctx, &r);
}

static void too_many_stages_are_left_out(void **state)
{
    (void)state;
    static const char name[HPR_MAX_STAGES + 3][2] = {"a", "b", "c", "d", "e", "f", "g", "h", "i", "j",
                                                     "k", "l", "m", "n", "o", "p", "q", "r", "s"};
    record r;
    hpr_context *ctx = make_context(&r);
    for (int i = 0; i < HPR_MAX_STAGES + 3; i++) {
        hpr_stage_begin(ctx, name[i]);
        hpr_stage_end(ctx);
    }
    hpr_stage_time times[HPR_MAX_STAGES];
    assert_int_equal(hpr_stage_times(ctx, times), HPR_MAX_STAGES);
    finish(ctx, &r);
}

static void unknown_instruction_sets_are_refused(void **state)
{
    (void)state;
    static const char *const bad[] = {"avx1024", "", "AVX2", "sse2 "};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hpr_context_options options;
        hpr_context_options_init(&options);
        options.isa = bad[i];
        hpr_context *ctx = (hpr_context *)&options;
        assert_int_equal(hpr_context_create(&options, &ctx), HPR_ERR_ARG);
        assert_null(ctx);
    }
}

static void known_instruction_sets_are_used_or_refused(void **state)
{
    (void)state;
    static const char *const known[] = {"sse2", "avx2", "avx512"};
    for (size_t i = 0; i < 3; i++) {
        hpr_context_options options;
        hpr_context_options_init(&options);
        options.isa = known[i];
        hpr_context *ctx;
        hpr_status status = hpr_context_create(&options, &ctx);
        if (status == HPR_OK) {
            assert_string_equal(hpr_context_isa(ctx), known[i]);
            assert_int_equal(hpr_context_isa_level(ctx), i);
        } else {
            assert_int_equal(status, HPR_ERR_ARG);
            assert_true(i > 0); /* sse2 is always there */
        }
        hpr_context_destroy(&ctx);
    }
}

static void auto_is_the_best_instruction_set(void **state)
{
    (void)state;
    hpr_context *any, *best;
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.isa = "auto";
    assert_int_equal(hpr_context_create(&options, &any), HPR_OK);
    assert_int_equal(hpr_context_create(NULL, &best), HPR_OK);
    assert_int_equal(hpr_context_isa_level(any), hpr_context_isa_level(best));
    hpr_context_destroy(&any);
    hpr_context_destroy(&best);
}

/* Threads of a context made with this OMP_NUM_THREADS (NULL: unset) and this option. */
static int threads_with(const char *variable, int asked)
{
    if (variable)
        setenv("OMP_NUM_THREADS", variable, 1);
    else
        unsetenv("OMP_NUM_THREADS");
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.threads = asked;
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    int threads = hpr_context_threads(ctx);
    hpr_context_destroy(&ctx);
    return threads;
}

static void thread_counts_come_in_order(void **state)
{
    (void)state;
    cpu_set_t set;
    assert_int_equal(sched_getaffinity(0, sizeof set, &set), 0);
    int affinity = CPU_COUNT(&set);
    assert_int_equal(threads_with("3", 0), 3);
    assert_int_equal(threads_with("3", 7), 7);
    assert_int_equal(threads_with("5,2", 0), 5); /* OpenMP's list: one number per nesting level */
    assert_int_equal(threads_with(" 6", 0), 6);
    assert_int_equal(threads_with(NULL, 0), affinity);
    static const char *const nonsense[] = {"", "0", "-4", "many", "1000000", "99999999999999999999"};
    for (size_t i = 0; i < sizeof nonsense / sizeof *nonsense; i++)
        assert_int_equal(threads_with(nonsense[i], 0), affinity);
}

static void absurd_thread_counts_are_refused(void **state)
{
    (void)state;
    static const int bad[] = {-1, INT_MIN, 1000000, INT_MAX};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        hpr_context_options options;
        hpr_context_options_init(&options);
        options.threads = bad[i];
        hpr_context *ctx;
        assert_int_equal(hpr_context_create(&options, &ctx), HPR_ERR_ARG);
        assert_null(ctx);
    }
}

static void memory_is_zeroed_and_never_null_for_nothing(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    void *nothing = hpr_allocate(ctx, 0, 8);
    assert_non_null(nothing);
    hpr_release(ctx, nothing);
    unsigned char *some = hpr_allocate(ctx, 100, 1);
    for (int i = 0; i < 100; i++)
        assert_int_equal(some[i], 0);
    hpr_release(ctx, some);
    hpr_release(ctx, NULL);
    finish(ctx, &r);
}

static void sizes_that_overflow_are_refused(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    size_t before = r.allocator.calls;
    assert_null(hpr_allocate(ctx, SIZE_MAX / 8 + 1, 8));
    int *array = NULL;
    assert_int_equal(hpr_allocate_into(ctx, &array, SIZE_MAX / 2, 3, "things"), HPR_ERR_MEMORY);
    assert_null(array);
    assert_non_null(strstr(hpr_context_error(ctx), "things"));
    size_t capacity = 0;
    assert_int_equal(hpr_grow(ctx, &array, &capacity, SIZE_MAX, sizeof *array), HPR_ERR_MEMORY);
    assert_null(array);
    assert_int_equal(capacity, 0);
    assert_int_equal(r.allocator.calls, before);
    finish(ctx, &r);
}

static void a_growing_array_keeps_its_items(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    uint32_t *item = NULL;
    size_t capacity = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        assert_int_equal(hpr_grow(ctx, &item, &capacity, i + 1, sizeof *item), HPR_OK);
        assert_true(capacity > i);
        for (size_t tail = i; tail < capacity; tail++)
            assert_int_equal(item[tail], 0);
        item[i] = i + 1;
    }
    for (uint32_t i = 0; i < 1000; i++)
        assert_int_equal(item[i], i + 1);
    hpr_release(ctx, item);
    finish(ctx, &r);
}

static void an_array_that_cannot_grow_stays(void **state)
{
    (void)state;
    record r;
    hpr_context *ctx = make_context(&r);
    uint32_t *item = NULL;
    size_t capacity = 0;
    assert_int_equal(hpr_grow(ctx, &item, &capacity, 4, sizeof *item), HPR_OK);
    item[3] = 9;
    size_t old = capacity;
    r.allocator.fail_at = r.allocator.calls;
    assert_int_equal(hpr_grow(ctx, &item, &capacity, old + 1, sizeof *item), HPR_ERR_MEMORY);
    assert_int_equal(capacity, old);
    assert_int_equal(item[3], 9);
    hpr_release(ctx, item);
    finish(ctx, &r);
}

static void cancel_is_seen(void **state)
{
    (void)state;
    volatile sig_atomic_t cancel = 0;
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.cancel = &cancel;
    hpr_context *ctx;
    assert_int_equal(hpr_context_create(&options, &ctx), HPR_OK);
    assert_false(hpr_cancelled(ctx));
    cancel = 1;
    assert_true(hpr_cancelled(ctx));
    hpr_context_destroy(&ctx);
    assert_int_equal(hpr_context_create(NULL, &ctx), HPR_OK);
    assert_false(hpr_cancelled(ctx));
    hpr_context_destroy(&ctx);
}

static void every_status_has_its_own_text(void **state)
{
    (void)state;
    for (int i = HPR_OK; i <= HPR_ERR_DEVICE; i++) {
        assert_true(strlen(hpr_status_string((hpr_status)i)) > 0);
        for (int j = HPR_OK; j < i; j++)
            assert_string_not_equal(hpr_status_string((hpr_status)i), hpr_status_string((hpr_status)j));
    }
    assert_string_equal(hpr_status_string((hpr_status)(HPR_ERR_DEVICE + 1)), "unknown status");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_context_without_options_works),
        cmocka_unit_test(create_survives_without_memory),
        cmocka_unit_test(half_an_allocator_is_refused),
        cmocka_unit_test(the_first_error_wins),
        cmocka_unit_test(a_cleared_error_makes_room),
        cmocka_unit_test(a_long_error_is_cut),
        cmocka_unit_test(a_warning_is_said_once),
        cmocka_unit_test(an_info_is_said_every_time),
        cmocka_unit_test(a_warning_without_memory_is_still_said),
        cmocka_unit_test(threads_share_a_context),
        cmocka_unit_test(stage_times_add_up),
        cmocka_unit_test(progress_names_the_running_stage),
        cmocka_unit_test(too_many_stages_are_left_out),
        cmocka_unit_test(unknown_instruction_sets_are_refused),
        cmocka_unit_test(known_instruction_sets_are_used_or_refused),
        cmocka_unit_test(auto_is_the_best_instruction_set),
        cmocka_unit_test(thread_counts_come_in_order),
        cmocka_unit_test(absurd_thread_counts_are_refused),
        cmocka_unit_test(memory_is_zeroed_and_never_null_for_nothing),
        cmocka_unit_test(sizes_that_overflow_are_refused),
        cmocka_unit_test(a_growing_array_keeps_its_items),
        cmocka_unit_test(an_array_that_cannot_grow_stays),
        cmocka_unit_test(cancel_is_seen),
        cmocka_unit_test(every_status_has_its_own_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
