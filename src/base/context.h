/* The context as the modules see it: errors, warnings, memory, cancellation, counters, stage times. */
#ifndef HPR_BASE_CONTEXT_H
#define HPR_BASE_CONTEXT_H

#include <hprad/context.h>
#include <stdbool.h>

#if defined(__GNUC__)
#define HPR_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define HPR_PRINTF(text, first)
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum hpr_isa { HPR_ISA_SSE2, HPR_ISA_AVX2, HPR_ISA_AVX512 } hpr_isa;

typedef enum hpr_counter {
    HPR_COUNT_KERNEL,        /* evaluations of G */
    HPR_COUNT_RAYS,          /* visibility rays */
    HPR_COUNT_CLIPS,         /* points for which a sender was clipped against blockers */
    HPR_COUNT_CAMERA_RAYS,   /* primary rays */
    HPR_COUNT_BLOCKS,        /* blocks integrated */
    HPR_COUNT_PAIRS_HIDDEN,  /* element pairs that cannot see each other */
    HPR_COUNT_PAIRS_VISIBLE, /* element pairs that see each other wholly */
    HPR_COUNT_PAIRS_PARTIAL, /* element pairs that may be blocked */
    HPR_COUNT_SAMPLED,       /* blocks whose visibility was sampled by rays */
    HPR_COUNT_SHORT,         /* blocks whose quadrature stopped short of its tolerance */
    HPR_COUNT_ROUNDED,       /* blocks that only rounding of the coordinates may keep from it */
    HPR_COUNT_TEXTURES,      /* means of textures over faces, or over whole pictures */
    HPR_COUNTER_COUNT
} hpr_counter;

enum { HPR_MAX_STAGES = 16 };

typedef struct hpr_stage_time {
    const char *name; /* static text */
    double wall_s, cpu_s;
} hpr_stage_time;

/* Writes the message (first failure wins until the context is reused) and returns `status`. Thread-safe. */
hpr_status hpr_fail(hpr_context *ctx, hpr_status status, const char *format, ...) HPR_PRINTF(3, 4);

/* Says a warning once: a text that was said before on this context is dropped. Thread-safe. */
void hpr_warn(hpr_context *ctx, const char *format, ...) HPR_PRINTF(2, 3);
void hpr_info(hpr_context *ctx, const char *format, ...) HPR_PRINTF(2, 3);

/* Forgets the last error message; every public entry point calls it first. */
void hpr_context_clear_error(hpr_context *ctx);

/* Zeroed memory of count*size bytes, overflow checked; NULL when there is none (count 0 gives non-NULL). */
void *hpr_allocate(hpr_context *ctx, size_t count, size_t size);
/* The usual form: allocates into *pointer and fails with the message "out of memory". */
hpr_status hpr_allocate_into(hpr_context *ctx, void *pointer, size_t count, size_t size, const char *what);
void hpr_release(hpr_context *ctx, void *memory);
/* The same for memory that begins at a multiple of `alignment`, a power of two; to be released by
 * hpr_release_aligned. */
hpr_status hpr_allocate_aligned(hpr_context *ctx, void *pointer, size_t size, size_t alignment,
                                const char *what);
void hpr_release_aligned(hpr_context *ctx, void *memory);
/* Grows *pointer (zeroed tail) so that it holds `needed` items; *capacity is kept in items. */
hpr_status hpr_grow(hpr_context *ctx, void *pointer, size_t *capacity, size_t needed, size_t size);
/* Bytes of memory of this machine. */
double hpr_machine_bytes(void);
char *hpr_duplicate_text(hpr_context *ctx, const char *text);

bool hpr_cancelled(const hpr_context *ctx);
/* What it polls, for a context of a part of the work; NULL: nothing. */
const volatile sig_atomic_t *hpr_context_cancel(const hpr_context *ctx);
hpr_isa hpr_context_isa_level(const hpr_context *ctx);

/* Adds to a counter. Thread-safe; integer, so the order does not matter. */
void hpr_count(hpr_context *ctx, hpr_counter counter, uint64_t amount);
uint64_t hpr_counter_value(const hpr_context *ctx, hpr_counter counter);

/* Stages do not nest. A stage that is begun twice adds up. Progress is reported for the running stage. */
void hpr_stage_begin(hpr_context *ctx, const char *name);
void hpr_stage_progress(hpr_context *ctx, double fraction);
void hpr_tell_accuracy(hpr_context *ctx, double error, double tolerance);
void hpr_stage_end(hpr_context *ctx);
size_t hpr_stage_times(const hpr_context *ctx, hpr_stage_time times[HPR_MAX_STAGES]);

/* Warnings said so far on this context, for reports. Valid while no further warning is said. */
size_t hpr_warning_count(const hpr_context *ctx);
const char *hpr_warning_text(const hpr_context *ctx, size_t index);

#ifdef __cplusplus
}
#endif

#endif
