/* Numbers in [0,1) by seed. Source: Knuth 1998, The Art of Computer Programming 2, 3.3.4 (MMIX). */
#ifndef HPR_TESTS_LCG_H
#define HPR_TESTS_LCG_H

#include <stdint.h>

static inline double random_unit(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) * 0x1p-53;
}

#endif
