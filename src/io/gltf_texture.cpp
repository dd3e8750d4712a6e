/* Images and textures: decoding, and the mean of a texture over a triangle. */
#include "io/gltf_texture.hpp"

#include <cmath>
#include <cstring>

namespace gltf
{

namespace
{

/* Bounds what a small file may unfold to: 8192 x 8192 in 16-bit RGBA is half a gigabyte. */
const uint64_t max_pixels = 1 << 26;
const size_t max_image_bytes = 1 << 30;

unsigned big_u32(const unsigned char *at)
{
    return static_cast<unsigned>(at[0]) << 24 | static_cast<unsigned>(at[1]) << 16 |
           static_cast<unsigned>(at[2]) << 8 | at[3];
}

struct size2 {
    uint64_t width = 0, height = 0;
};

/* Width and height from a JPEG's first frame header; zero if there is none. */
size2 jpeg_size(const unsigned char *data, size_t size)
{
    for (size_t at = 2; at + 9 < size;) {
        if (data[at] != 0xff)
            return {};
        unsigned marker = data[at + 1];
        if (marker == 0xff) { /* fill byte */
            at++;
            continue;
        }
        bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
        if (frame)
            return {static_cast<uint64_t>(data[at + 7] << 8 | data[at + 8]),
                    static_cast<uint64_t>(data[at + 5] << 8 | data[at + 6])};
        at += 2 + static_cast<size_t>(data[at + 2] << 8 | data[at + 3]);
    }
    return {};
}

size2 image_size(const unsigned char *data, size_t size)
{
    static const unsigned char png[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    if (size >= 33 && std::memcmp(data, png, sizeof png) == 0 && std::memcmp(data + 12, "IHDR", 4) == 0)
        return {big_u32(data + 16), big_u32(data + 20)};
    if (size >= 4 && data[0] == 0xff && data[1] == 0xd8 && data[2] == 0xff)
        return jpeg_size(data, size);
    return {};
}

std::string image_label(const document &doc, int index)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "images");
    item = cJSON_GetArrayItem(item, index);
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "name"));
    const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "uri"));
    bool file = uri && std::strncmp(uri, "data:", 5) != 0;
    return label("image", static_cast<size_t>(index), name && *name ? name : file ? uri : "");
}

void decode(const document &doc, int index, const unsigned char *data, size_t size, tinygltf::Image &image)
{
    std::string what = image_label(doc, index), error, warning;
    size2 expected = image_size(data, size);
    if (expected.width == 0 || expected.height == 0)
        fail(doc, HPR_ERR_FORMAT, "%s is neither a PNG nor a JPEG, or has no size", what.c_str());
    if (expected.width > max_pixels || expected.height > max_pixels ||
        expected.width * expected.height > max_pixels)
        fail(doc, HPR_ERR_UNSUPPORTED, "%s has %llu x %llu pixels; hprad takes up to %llu in all",
             what.c_str(), static_cast<unsigned long long>(expected.width),
             static_cast<unsigned long long>(expected.height), static_cast<unsigned long long>(max_pixels));
    bool good =
        tinygltf::LoadImageData(&image, index, &error, &warning, 0, 0, data, static_cast<int>(size), nullptr);
    size_t depth = static_cast<size_t>(image.bits) / 8;
    if (!good || image.component != 4 || static_cast<uint64_t>(image.width) != expected.width ||
        static_cast<uint64_t>(image.height) != expected.height ||
        image.image.size() != expected.width * expected.height * 4 * depth)
        fail(doc, HPR_ERR_FORMAT, "%s cannot be decoded: damaged, or an unusual kind of PNG or JPEG",
             what.c_str());
}

tinygltf::Image load_image(document &doc, int index)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "images");
    item = cJSON_GetArrayItem(item, index);
    const cJSON *place = cJSON_GetObjectItemCaseSensitive(item, "bufferView");
    const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "uri"));
    std::string what = image_label(doc, index);
    if ((place != nullptr) == (uri != nullptr))
        fail(doc, HPR_ERR_FORMAT, "%s must have either a uri or a bufferView", what.c_str());
    tinygltf::Image image;
    if (uri) {
        bytes data = load_uri(doc, uri, what, max_image_bytes);
        decode(doc, index, data.data(), data.size(), image);
    } else {
        view v = open_view(doc, place->valueint);
        if (v.size > max_image_bytes)
            fail(doc, HPR_ERR_UNSUPPORTED, "%s has %zu bytes; hprad takes up to %zu", what.c_str(), v.size,
                 max_image_bytes);
        decode(doc, index, v.data, v.size, image);
    }
    return image;
}

/* sRGB (IEC 61966-2-1) to linear light. */
double linear_light(double s)
{
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

hpr_wrap read_wrap(const document &doc, int index, int code)
{
    switch (code) {
    case TINYGLTF_TEXTURE_WRAP_REPEAT:
        return HPR_WRAP_REPEAT;
    case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return HPR_WRAP_MIRROR;
    case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return HPR_WRAP_CLAMP;
    default:
        fail(doc, HPR_ERR_FORMAT, "sampler %d has the wrap mode %d, which glTF does not know", index, code);
    }
}

/* Are all pixels equal, alpha aside? */
bool is_uniform(const tinygltf::Image &image)
{
    size_t pixel = static_cast<size_t>(image.bits) / 2, used = pixel / 4 * 3; /* bytes of RGBA, of RGB */
    for (size_t at = pixel; at + used <= image.image.size(); at += pixel) {
        if (std::memcmp(image.image.data(), image.image.data() + at, used) != 0)
            return false;
    }
    return true;
}

/* One step of the pyramid along x: every texel is the mean of what it covers, so that the whole keeps its
 * mean also where the old width is odd. Positions count in 1/width of an old texel. */
level halve_width(const level &from)
{
    level to;
    to.width = from.width > 1 ? from.width / 2 : 1;
    to.height = from.height;
    to.texel.resize(3 * static_cast<size_t>(to.width) * static_cast<size_t>(to.height));
    auto wide = static_cast<int64_t>(from.width), narrow = static_cast<int64_t>(to.width);
    for (int y = 0; y < to.height; y++) {
        for (int x = 0; x < to.width; x++) {
            int64_t begin = x * wide, end = begin + wide;
            double sum[3] = {0, 0, 0};
            for (int64_t i = begin / narrow; i * narrow < end; i++) {
                int64_t overlap = std::min(end, (i + 1) * narrow) - std::max(begin, i * narrow);
                rgb value = from.at(static_cast<int>(i), y);
                for (size_t c = 0; c < 3; c++)
                    sum[c] += static_cast<double>(overlap) * value[c];
            }
            for (size_t c = 0; c < 3; c++)
                to.put(x, y, c, sum[c] / static_cast<double>(wide));
        }
    }
    return to;
}

level transpose(const level &from)
{
    level to;
    to.width = from.height;
    to.height = from.width;
    to.texel.resize(3 * static_cast<size_t>(to.width) * static_cast<size_t>(to.height));
    for (int y = 0; y < to.height; y++) {
        for (int x = 0; x < to.width; x++) {
            rgb value = from.at(y, x);
            for (size_t c = 0; c < 3; c++)
                to.put(x, y, c, value[c]);
        }
    }
    return to;
}

} // namespace

rgb level::at(int x, int y) const
{
    size_t i = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
    if (!image)
        return {texel[3 * i], texel[3 * i + 1], texel[3 * i + 2]};
    rgb out;
    for (size_t c = 0; c < 3; c++) {
        if (image->bits == 16) {
            uint16_t code;
            std::memcpy(&code, image->image.data() + 2 * (4 * i + c), 2);
            out[c] = (*table)[code];
        } else {
            out[c] = (*table)[image->image[4 * i + c]];
        }
    }
    return out;
}

void level::put(int x, int y, size_t channel, double value)
{
    size_t i = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
    texel[3 * i + channel] = static_cast<float>(value);
}

const level &texture::at_level(size_t index)
{
    while (pyramid.size() <= index)
        pyramid.push_back(transpose(halve_width(transpose(halve_width(pyramid.back())))));
    return pyramid[index];
}

texture_set::texture_set(document &document) : doc(document), cache(document.model.textures.size()) {}

texture_set::~texture_set() = default;

texture &texture_set::open(int index)
{
    std::unique_ptr<texture> &slot = cache[static_cast<size_t>(index)];
    if (slot)
        return *slot;
    const tinygltf::Texture &from = doc.model.textures[static_cast<size_t>(index)];
    if (from.source < 0)
        fail(doc, HPR_ERR_UNSUPPORTED, "%s has no PNG or JPEG source",
             label("texture", static_cast<size_t>(index), from.name).c_str());
    auto made = std::make_unique<texture>();
    if (from.sampler >= 0) {
        const tinygltf::Sampler &sampler = doc.model.samplers[static_cast<size_t>(from.sampler)];
        made->wrap_s = read_wrap(doc, from.sampler, sampler.wrapS);
        made->wrap_t = read_wrap(doc, from.sampler, sampler.wrapT);
        made->nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
    }
    made->image = load_image(doc, from.source);
    double top = made->image.bits == 16 ? 65535 : 255;
    for (int i = 0; i <= static_cast<int>(top); i++)
        made->table.push_back(linear_light(i / top));
    level base;
    base.width = made->image.width;
    base.height = made->image.height;
    base.image = &made->image;
    base.table = &made->table;
    made->uniform = is_uniform(made->image);
    made->pyramid.push_back(base);
    slot = std::move(made);
    return *slot;
}

std::optional<uint32_t> texture_set::hand_on(int index, hpr_scene *scene)
{
    texture &tex = open(index);
    if (tex.uniform || tex.scene_index)
        return tex.scene_index;
    const level &base = tex.at_level(0);
    std::vector<float> texel;
    texel.reserve(3 * static_cast<size_t>(base.width) * static_cast<size_t>(base.height));
    for (int y = 0; y < base.height; y++) {
        for (int x = 0; x < base.width; x++) {
            for (double value : base.at(x, y))
                texel.push_back(static_cast<float>(value));
        }
    }
    hpr_texture add = {};
    add.width = static_cast<uint32_t>(base.width);
    add.height = static_cast<uint32_t>(base.height);
    add.wrap[0] = static_cast<uint8_t>(tex.wrap_s);
    add.wrap[1] = static_cast<uint8_t>(tex.wrap_t);
    add.nearest = tex.nearest;
    add.texel = texel.data();
    uint32_t place = 0;
    check(hpr_scene_add_texture(scene, &add, &place));
    tex.scene_index = place;
    return tex.scene_index;
}

std::optional<rgb> only_colour(texture &tex)
{
    if (!tex.uniform)
        return std::nullopt;
    return tex.at_level(0).at(0, 0);
}

texture_use read_texture_use(const tinygltf::TextureInfo &info)
{
    texture_use use;
    use.index = info.index;
    use.set = info.texCoord;
    auto found = info.extensions.find("KHR_texture_transform");
    if (found == info.extensions.end())
        return use;
    const tinygltf::Value &transform = found->second;
    double scale[2] = {1, 1}, angle = 0;
    for (int a = 0; a < 2; a++) {
        if (transform.Has("scale"))
            scale[a] = transform.Get("scale").Get(a).GetNumberAsDouble();
        if (transform.Has("offset"))
            use.offset[a] = transform.Get("offset").Get(a).GetNumberAsDouble();
    }
    if (transform.Has("rotation"))
        angle = transform.Get("rotation").GetNumberAsDouble();
    if (transform.Has("texCoord"))
        use.set = transform.Get("texCoord").GetNumberAsInt();
    /* The extension's order is offset * rotation * scale, its rotation counter-clockwise with v downwards. */
    use.matrix[0][0] = std::cos(angle) * scale[0];
    use.matrix[0][1] = std::sin(angle) * scale[1];
    use.matrix[1][0] = -std::sin(angle) * scale[0];
    use.matrix[1][1] = std::cos(angle) * scale[1];
    return use;
}

} // namespace gltf
