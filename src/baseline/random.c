#include "baseline/random.h"

__extension__ typedef unsigned __int128 wide;

void hpr_philox(const uint64_t counter[HPR_PHILOX_WORDS], const uint64_t key[2],
                uint64_t word[HPR_PHILOX_WORDS])
{
    enum { ROUNDS = 10 };
    static const uint64_t factor0 = 0xD2E7470EE14C6C93u, factor1 = 0xCA5A826395121157u;
    static const uint64_t step0 = 0x9E3779B97F4A7C15u, step1 = 0xBB67AE8584CAA73Bu;
    uint64_t w0 = counter[0], w1 = counter[1], w2 = counter[2], w3 = counter[3], k0 = key[0], k1 = key[1];
    for (int round = 0; round < ROUNDS; round++) {
        wide product0 = (wide)factor0 * w0, product1 = (wide)factor1 * w2;
        w0 = (uint64_t)(product1 >> 64) ^ w1 ^ k0;
        w1 = (uint64_t)product1;
        w2 = (uint64_t)(product0 >> 64) ^ w3 ^ k1;
        w3 = (uint64_t)product0;
        k0 += step0;
        k1 += step1;
    }
    word[0] = w0;
    word[1] = w1;
    word[2] = w2;
    word[3] = w3;
}
