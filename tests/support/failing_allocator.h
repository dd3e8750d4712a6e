/*
 * A counting allocator whose k-th allocation fails, and the sweep over every k. For tests of everything that
 * allocates through a context:
 *
 *     static hpr_status make_thing(hpr_context *ctx, void *data) { ...create, destroy, return the status... }
 *     static void thing_survives_without_memory(void **state) { sweep_allocations(make_thing, NULL, 2); }
 */
#ifndef HPR_TESTS_FAILING_ALLOCATOR_H
#define HPR_TESTS_FAILING_ALLOCATOR_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>
#include <hprad/context.h>

/* Initialise with FAILING_ALLOCATOR_INIT; the counts are atomic, parallel stages may allocate. */
typedef struct failing_allocator {
    size_t fail_at;       /* index of the allocation that fails, SIZE_MAX: none does */
    _Atomic size_t calls; /* allocations asked for so far */
    _Atomic size_t live;  /* allocations not yet released */
    atomic_bool failed;   /* the one at fail_at has been asked for */
} failing_allocator;

#define FAILING_ALLOCATOR_INIT                                                                               \
    {                                                                                                        \
        .fail_at = SIZE_MAX                                                                                  \
    }

static inline void *failing_allocate(void *user, size_t count, size_t size)
{
    failing_allocator *allocator = user;
    if (allocator->calls++ == allocator->fail_at) {
        allocator->failed = true;
        return NULL;
    }
    void *memory = calloc(count, size);
    if (memory)
        allocator->live++;
    return memory;
}

static inline void failing_release(void *user, void *memory)
{
    failing_allocator *allocator = user;
    if (memory)
        allocator->live--;
    free(memory);
}

/* Context options that allocate here; further fields may be set before the context is made. */
static inline hpr_context_options failing_options(failing_allocator *allocator)
{
    hpr_context_options options;
    hpr_context_options_init(&options);
    options.allocate = failing_allocate;
    options.release = failing_release;
    options.user = allocator;
    return options;
}

/*
 * Runs `body` with a fresh context whose k-th allocation fails, k = 0, 1, 2 … until none fails any more. Each
 * time: if one failed, HPR_ERR_MEMORY and a message; in the end HPR_OK; never anything left. The context's
 * own allocation is k = 0. `body` destroys what it made, also on failure. `threads`: of the context.
 * Returns the number of allocations of a run that succeeds. Not for bodies that warn: a warning that finds no
 * memory is said all the same.
 */
static inline size_t sweep_allocations(hpr_status (*body)(hpr_context *ctx, void *data), void *data,
                                       int threads)
{
    for (size_t k = 0;; k++) {
        failing_allocator allocator = {.fail_at = k};
        hpr_context_options options = failing_options(&allocator);
        options.threads = threads;
        hpr_context *ctx = NULL;
        hpr_status status = hpr_context_create(&options, &ctx);
        if (status == HPR_OK) {
            status = body(ctx, data);
            if (status != HPR_OK && !hpr_context_error(ctx)[0])
                fail_msg("allocation %zu fails: status '%s' without a message", k, hpr_status_string(status));
        }
        hpr_context_destroy(&ctx);
        hpr_status expected = allocator.failed ? HPR_ERR_MEMORY : HPR_OK;
        if (status != expected)
            fail_msg("allocation %zu %s: status '%s', expected '%s'", k,
                     allocator.failed ? "fails" : "is not reached", hpr_status_string(status),
                     hpr_status_string(expected));
        if (allocator.live)
            fail_msg("allocation %zu %s: %zu allocations leaked", k,
                     allocator.failed ? "fails" : "is not reached", (size_t)allocator.live);
        if (!allocator.failed)
            return allocator.calls;
    }
}

#endif
