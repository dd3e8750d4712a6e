#include "link/kept.h"

#include <string.h>

/* The link as it was before. */
static const hpr_link *find_known(const hpr_links *known, const hpr_link *pair)
{
    if (!known || pair->recv >= known->row_count || pair->send >= known->row_count)
        return NULL;
    for (size_t i = known->row[pair->recv]; i < known->row[pair->recv + 1]; i++) {
        const hpr_link *old = &known->link[known->row_link[i]];
        if (old->recv == pair->recv && old->send == pair->send && old->recv_degree == pair->recv_degree &&
            old->send_degree == pair->send_degree)
            return old;
    }
    return NULL;
}

static hpr_kept_block describe(const hpr_link *pair, size_t count)
{
    return (hpr_kept_block){.recv = pair->recv,
                            .send = pair->send,
                            .recv_degree = pair->recv_degree,
                            .send_degree = pair->send_degree,
                            .count = (uint32_t)count};
}

bool hpr_kept_take(const hpr_kept *kept, const hpr_link *pair, size_t count, double *block,
                   hpr_link_note *note)
{
    const hpr_link *old = find_known(kept->known, pair);
    if (old) {
        memcpy(block, kept->known->block + old->offset, count * sizeof *block);
        *note = kept->known->note[old - kept->known->link];
        return true;
    }
    hpr_kept_block found = describe(pair, count);
    if (!kept->keeper || !kept->keeper->find || !kept->keeper->find(kept->keeper->user, &found))
        return false;
    memcpy(block, found.block, count * sizeof *block);
    *note = (hpr_link_note){.error = found.error,
                            .sampled_error = found.sampled_error,
                            .sampled2 = found.sampled2,
                            .short_count = found.short_count};
    return true;
}

void hpr_kept_give(const hpr_kept *kept, const hpr_link *pair, size_t count, const double *block,
                   const hpr_link_note *note)
{
    if (!kept->keeper || !kept->keeper->keep)
        return;
    hpr_kept_block made = describe(pair, count);
    made.short_count = note->short_count;
    made.error = note->error;
    made.sampled_error = note->sampled_error;
    made.sampled2 = note->sampled2;
    made.block = block;
    kept->keeper->keep(kept->keeper->user, &made);
}
