#ifndef HPRAD_CONTEXT_H
#define HPRAD_CONTEXT_H

#include <hprad/status.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Everything that calls share: threads, instruction set, messages, memory, counters. */
typedef struct hpr_context hpr_context;

typedef enum hpr_log_level { HPR_LOG_WARNING, HPR_LOG_INFO } hpr_log_level;

/**
 * How a context behaves. Callbacks may be NULL. `log`, `progress` and `accuracy` are called by the thread
 * that called the library, or by one worker at a time. `cancel` is polled; when it becomes non-zero, the
 * running call returns HPR_ERR_INTERRUPTED. `allocate` must behave like calloc, `release` like free; both or
 * neither.
 */
typedef struct hpr_context_options {
    int threads;     /**< 0: OMP_NUM_THREADS, else the affinity mask */
    const char *isa; /**< NULL or "auto": best available; else "sse2", "avx2", "avx512" */
    void (*log)(void *user, hpr_log_level level, const char *text);
    void (*progress)(void *user, const char *stage, double fraction);
    /** After each of the solves towards a tolerance: the estimated error. */
    void (*accuracy)(void *user, double error, double tolerance);
    void *(*allocate)(void *user, size_t count, size_t size);
    void (*release)(void *user, void *memory);
    void *user;
    const volatile sig_atomic_t *cancel;
} hpr_context_options;

/** Fills in the defaults. */
HPR_API void hpr_context_options_init(hpr_context_options *options);

/**
 * Makes a context. `options` may be NULL. Errors: HPR_ERR_ARG (unknown or unavailable instruction set, thread
 * count outside 0 .. 1024, half an allocator), HPR_ERR_MEMORY; with no context there is no message beyond the
 * status.
 * A context serves one call at a time.
 */
HPR_API hpr_status hpr_context_create(const hpr_context_options *options, hpr_context **context);

/** Frees it; accepts NULL and sets NULL. Everything made with it must be destroyed before. */
HPR_API void hpr_context_destroy(hpr_context **context);

/** The text of the last error on this context, "" if none. Valid until the next failing call. */
HPR_API const char *hpr_context_error(const hpr_context *context);

/** Number of worker threads in use. */
HPR_API int hpr_context_threads(const hpr_context *context);

/** Name of the instruction set in use: "sse2", "avx2" or "avx512". Static text. */
HPR_API const char *hpr_context_isa(const hpr_context *context);

#ifdef __cplusplus
}
#endif

#endif
