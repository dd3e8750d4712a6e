#include "base/context.h"

#include <assert.h>
#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* A mistyped thread count must not make OpenMP abort; cpu_set_t has no more processors either. */
enum { MESSAGE_BYTES = 1024, MAX_THREADS = CPU_SETSIZE };

struct hpr_context {
    hpr_context_options options;
    int threads;
    hpr_isa isa;
    pthread_mutex_t lock; /* guards error, warnings and the callbacks */
    char error[MESSAGE_BYTES];
    char **warnings;
    size_t warning_count, warning_capacity;
    _Atomic uint64_t counters[HPR_COUNTER_COUNT];
    hpr_stage_time stages[HPR_MAX_STAGES];
    size_t stage_count;
    size_t stage; /* index of the running stage, HPR_MAX_STAGES if none */
    struct timespec stage_wall, stage_cpu;
};

static const char *const isa_names[] = {"sse2", "avx2", "avx512"};

static void *default_allocate(void *user, size_t count, size_t size)
{
    (void)user;
    return calloc(count, size);
}

static void default_release(void *user, void *memory)
{
    (void)user;
    free(memory);
}

void hpr_context_options_init(hpr_context_options *options)
{
    *options = (hpr_context_options){.allocate = default_allocate, .release = default_release};
}

static bool isa_available(hpr_isa isa)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    switch (isa) {
    case HPR_ISA_SSE2:
        return true;
    case HPR_ISA_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case HPR_ISA_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("fma");
    }
#endif
    return isa == HPR_ISA_SSE2;
}

static hpr_status choose_isa(const char *name, hpr_isa *isa)
{
    if (!name || !strcmp(name, "auto")) {
        for (int i = HPR_ISA_AVX512; i >= 0; i--) {
            if (isa_available((hpr_isa)i)) {
                *isa = (hpr_isa)i;
                return HPR_OK;
            }
        }
    }
    for (int i = 0; name && i <= HPR_ISA_AVX512; i++) {
        if (!strcmp(name, isa_names[i]) && isa_available((hpr_isa)i)) {
            *isa = (hpr_isa)i;
            return HPR_OK;
        }
    }
    return HPR_ERR_ARG;
}

static int choose_threads(int asked)
{
    if (asked > 0)
        return asked;
    const char *text = getenv("OMP_NUM_THREADS"); /* may be a list, one number per nesting level */
    long number = text ? strtol(text, NULL, 10) : 0;
    if (number > 0 && number <= MAX_THREADS)
        return (int)number;
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof set, &set) == 0)
        return CPU_COUNT(&set);
    return 1;
}

hpr_status hpr_context_create(const hpr_context_options *options, hpr_context **context)
{
    hpr_context_options used;
    hpr_context_options_init(&used);
    *context = NULL;
    if (options) {
        hpr_context_options defaults = used;
        used = *options;
        if (used.threads < 0 || used.threads > MAX_THREADS || !used.allocate != !used.release)
            return HPR_ERR_ARG;
        if (!used.allocate) {
            used.allocate = defaults.allocate;
            used.release = defaults.release;
        }
    }
    hpr_isa isa;
    if (choose_isa(used.isa, &isa) != HPR_OK)
        return HPR_ERR_ARG;
    hpr_context *ctx = used.allocate(used.user, 1, sizeof *ctx);
    if (!ctx)
        return HPR_ERR_MEMORY;
    ctx->options = used;
    ctx->threads = choose_threads(used.threads);
    ctx->isa = isa;
    ctx->stage = HPR_MAX_STAGES;
    pthread_mutex_init(&ctx->lock, NULL);
    omp_set_num_threads(ctx->threads);
    *context = ctx;
    return HPR_OK;
}

void hpr_context_destroy(hpr_context **context)
{
    hpr_context *ctx = *context;
    if (!ctx)
        return;
    for (size_t i = 0; i < ctx->warning_count; i++)
        hpr_release(ctx, ctx->warnings[i]);
    hpr_release(ctx, ctx->warnings);
    pthread_mutex_destroy(&ctx->lock);
    ctx->options.release(ctx->options.user, ctx);
    *context = NULL;
}

const char *hpr_context_error(const hpr_context *ctx)
{
    return ctx->error;
}

int hpr_context_threads(const hpr_context *ctx)
{
    return ctx->threads;
}

const char *hpr_context_isa(const hpr_context *ctx)
{
    return isa_names[ctx->isa];
}

hpr_isa hpr_context_isa_level(const hpr_context *ctx)
{
    return ctx->isa;
}

void hpr_context_clear_error(hpr_context *ctx)
{
    ctx->error[0] = '\0';
}

hpr_status hpr_fail(hpr_context *ctx, hpr_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    pthread_mutex_lock(&ctx->lock);
    if (!ctx->error[0])
        vsnprintf(ctx->error, sizeof ctx->error, format, arguments);
    pthread_mutex_unlock(&ctx->lock);
    va_end(arguments);
    return status;
}

/* The lock is held. A warning that finds no memory is still said, only not remembered. */
static bool remember_warning(hpr_context *ctx, const char *text)
{
    for (size_t i = 0; i < ctx->warning_count; i++) {
        if (!strcmp(ctx->warnings[i], text))
            return false;
    }
    if (ctx->warning_count == ctx->warning_capacity) {
        size_t capacity = ctx->warning_capacity ? 2 * ctx->warning_capacity : 16;
        char **grown = hpr_allocate(ctx, capacity, sizeof *grown);
        if (!grown)
            return true;
        if (ctx->warning_count)
            memcpy(grown, ctx->warnings, ctx->warning_count * sizeof *grown);
        hpr_release(ctx, ctx->warnings);
        ctx->warnings = grown;
        ctx->warning_capacity = capacity;
    }
    char *copy = hpr_duplicate_text(ctx, text);
    if (copy)
        ctx->warnings[ctx->warning_count++] = copy;
    return true;
}

void hpr_warn(hpr_context *ctx, const char *format, ...)
{
    char text[MESSAGE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pthread_mutex_lock(&ctx->lock);
    if (remember_warning(ctx, text) && ctx->options.log)
        ctx->options.log(ctx->options.user, HPR_LOG_WARNING, text);
    pthread_mutex_unlock(&ctx->lock);
}

void hpr_info(hpr_context *ctx, const char *format, ...)
{
    if (!ctx->options.log)
        return;
    char text[MESSAGE_BYTES];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    pthread_mutex_lock(&ctx->lock);
    ctx->options.log(ctx->options.user, HPR_LOG_INFO, text);
    pthread_mutex_unlock(&ctx->lock);
}

size_t hpr_warning_count(const hpr_context *ctx)
{
    return ctx->warning_count;
}

const char *hpr_warning_text(const hpr_context *ctx, size_t index)
{
    return ctx->warnings[index];
}

void *hpr_allocate(hpr_context *ctx, size_t count, size_t size)
{
    if (count == 0)
        count = 1;
    if (size && count > SIZE_MAX / size)
        return NULL;
    return ctx->options.allocate(ctx->options.user, count, size);
}

hpr_status hpr_allocate_into(hpr_context *ctx, void *pointer, size_t count, size_t size, const char *what)
{
    void *memory = hpr_allocate(ctx, count, size);
    memcpy(pointer, &memory, sizeof memory);
    if (!memory)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: %zu x %zu bytes for %s", count, size, what);
    return HPR_OK;
}

void hpr_release(hpr_context *ctx, void *memory)
{
    if (memory)
        ctx->options.release(ctx->options.user, memory);
}

/* What was allocated stands before the memory that is handed out. */
hpr_status hpr_allocate_aligned(hpr_context *ctx, void *pointer, size_t size, size_t alignment,
                                const char *what)
{
    char *whole = NULL, *memory = NULL;
    assert(alignment >= sizeof whole && (alignment & (alignment - 1)) == 0 &&
           size <= SIZE_MAX - 2 * alignment);
    hpr_status status = hpr_allocate_into(ctx, &whole, 1, size + 2 * alignment, what);
    if (status == HPR_OK) {
        memory = whole + 2 * alignment - (uintptr_t)whole % alignment;
        memcpy(memory - sizeof whole, &whole, sizeof whole);
    }
    memcpy(pointer, &memory, sizeof memory);
    return status;
}

void hpr_release_aligned(hpr_context *ctx, void *memory)
{
    char *whole;
    if (!memory)
        return;
    memcpy(&whole, (char *)memory - sizeof whole, sizeof whole);
    hpr_release(ctx, whole);
}

hpr_status hpr_grow(hpr_context *ctx, void *pointer, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity)
        return HPR_OK;
    size_t grown_capacity = *capacity ? *capacity : 16;
    while (grown_capacity < needed) {
        if (grown_capacity > SIZE_MAX / 2)
            return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: %zu items", needed);
        grown_capacity *= 2;
    }
    void *old, *grown;
    memcpy(&old, pointer, sizeof old);
    hpr_status status = hpr_allocate_into(ctx, &grown, grown_capacity, size, "a growing array");
    if (status != HPR_OK)
        return status;
    if (*capacity)
        memcpy(grown, old, *capacity * size);
    hpr_release(ctx, old);
    memcpy(pointer, &grown, sizeof grown);
    *capacity = grown_capacity;
    return HPR_OK;
}

double hpr_machine_bytes(void)
{
    return (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGE_SIZE);
}

char *hpr_duplicate_text(hpr_context *ctx, const char *text)
{
    size_t bytes = strlen(text) + 1;
    char *copy = hpr_allocate(ctx, bytes, 1);
    if (copy)
        memcpy(copy, text, bytes);
    return copy;
}

const volatile sig_atomic_t *hpr_context_cancel(const hpr_context *ctx)
{
    return ctx->options.cancel;
}

bool hpr_cancelled(const hpr_context *ctx)
{
    return ctx->options.cancel && *ctx->options.cancel;
}

void hpr_count(hpr_context *ctx, hpr_counter counter, uint64_t amount)
{
    atomic_fetch_add_explicit(&ctx->counters[counter], amount, memory_order_relaxed);
}

uint64_t hpr_counter_value(const hpr_context *ctx, hpr_counter counter)
{
    return atomic_load_explicit(&((hpr_context *)ctx)->counters[counter], memory_order_relaxed);
}

static double seconds_since(const struct timespec *start, clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)(now.tv_sec - start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

void hpr_stage_begin(hpr_context *ctx, const char *name)
{
    size_t i = 0;
    while (i < ctx->stage_count && strcmp(ctx->stages[i].name, name))
        i++;
    if (i == HPR_MAX_STAGES)
        return;
    if (i == ctx->stage_count)
        ctx->stages[ctx->stage_count++] = (hpr_stage_time){.name = name};
    ctx->stage = i;
    clock_gettime(CLOCK_MONOTONIC, &ctx->stage_wall);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &ctx->stage_cpu);
    hpr_stage_progress(ctx, 0);
}

void hpr_stage_progress(hpr_context *ctx, double fraction)
{
    if (!ctx->options.progress || ctx->stage == HPR_MAX_STAGES)
        return;
    pthread_mutex_lock(&ctx->lock);
    ctx->options.progress(ctx->options.user, ctx->stages[ctx->stage].name, fraction);
    pthread_mutex_unlock(&ctx->lock);
}

void hpr_tell_accuracy(hpr_context *ctx, double error, double tolerance)
{
    if (!ctx->options.accuracy)
        return;
    pthread_mutex_lock(&ctx->lock);
    ctx->options.accuracy(ctx->options.user, error, tolerance);
    pthread_mutex_unlock(&ctx->lock);
}

void hpr_stage_end(hpr_context *ctx)
{
    if (ctx->stage == HPR_MAX_STAGES)
        return;
    hpr_stage_progress(ctx, 1);
    ctx->stages[ctx->stage].wall_s += seconds_since(&ctx->stage_wall, CLOCK_MONOTONIC);
    ctx->stages[ctx->stage].cpu_s += seconds_since(&ctx->stage_cpu, CLOCK_PROCESS_CPUTIME_ID);
    ctx->stage = HPR_MAX_STAGES;
}

size_t hpr_stage_times(const hpr_context *ctx, hpr_stage_time times[HPR_MAX_STAGES])
{
    memcpy(times, ctx->stages, ctx->stage_count * sizeof *times);
    return ctx->stage_count;
}
