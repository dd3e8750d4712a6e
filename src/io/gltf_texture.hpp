/* A decoded texture, between gltf_texture.cpp (makes it) and gltf_texture_mean.cpp (integrates it). */
#ifndef HPR_IO_GLTF_TEXTURE_HPP
#define HPR_IO_GLTF_TEXTURE_HPP

#include "io/gltf.hpp"

namespace gltf
{

/* One level of the pyramid. Level 0 stays as decoded and is looked up, which takes a third of the memory. */
struct level {
    int width = 0, height = 0;
    std::vector<float> texel; /* [height][width][3], linear light; level 0: empty */
    const tinygltf::Image *image = nullptr;
    const std::vector<double> *table = nullptr; /* code -> linear light */

    rgb at(int x, int y) const;
    void put(int x, int y, size_t channel, double value);
};


/* A mean over a triangle is that of the magnified texture: minFilter has no part in it. */
struct texture {
    tinygltf::Image image;
    std::vector<double> table;
    hpr_wrap wrap_s = HPR_WRAP_REPEAT, wrap_t = HPR_WRAP_REPEAT;
    bool nearest = false;
    bool uniform = false;               /* all texels are equal */
    std::optional<uint32_t> scene_index; /* once it was handed on */
    std::vector<level> pyramid;

    /* Level i has the size of level 0 halved i times, down to 1 x 1. */
    const level &at_level(size_t index);
};

} // namespace gltf

#endif
