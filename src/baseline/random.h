/*
 * Random numbers by counting: Philox4x64-10 (Salmon, Moraes, Dror & Shaw 2011). What comes out depends only
 * on the key and the place in the picture, never on which thread asks or what was asked before.
 */
#ifndef HPR_BASELINE_RANDOM_H
#define HPR_BASELINE_RANDOM_H

#include <stdint.h>

enum { HPR_PHILOX_WORDS = 4 };

/* The ten rounds: word = f(counter, key), a bijection of the counter for every key. */
void hpr_philox(const uint64_t counter[HPR_PHILOX_WORDS], const uint64_t key[2],
                uint64_t word[HPR_PHILOX_WORDS]);

/* The numbers of one path, in order. */
typedef struct hpr_random {
    uint64_t key[2], counter[HPR_PHILOX_WORDS], word[HPR_PHILOX_WORDS];
    int left; /* words not yet used */
} hpr_random;

/* Different streams for every four numbers. */
static inline hpr_random hpr_random_of(uint64_t seed, uint64_t picture, uint64_t pixel, uint64_t sample)
{
    return (hpr_random){.key = {seed, 0}, .counter = {0, sample, pixel, picture}};
}

/* Uniform in [0, 1), a multiple of 2^-53. */
static inline double hpr_random_unit(hpr_random *random)
{
    if (random->left == 0) {
        hpr_philox(random->counter, random->key, random->word);
        random->counter[0]++;
        random->left = HPR_PHILOX_WORDS;
    }
    return (double)(random->word[--random->left] >> 11) * 0x1p-53;
}

#endif
