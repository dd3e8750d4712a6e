/* From the bytes of a file to a checked tinygltf::Model. */
#include "io/gltf.hpp"

#include <climits>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>

namespace gltf
{

namespace
{

std::string print_list(const char *format, va_list arguments)
{
    char text[1024];
    std::vsnprintf(text, sizeof text, format, arguments);
    return text;
}

uint32_t little_u32(const bytes &file, size_t at)
{
    return file[at] | static_cast<uint32_t>(file[at + 1]) << 8 | static_cast<uint32_t>(file[at + 2]) << 16 |
           static_cast<uint32_t>(file[at + 3]) << 24;
}

/* Finds the JSON text of a .glb and notes its binary chunk; further chunks are skipped, as glTF asks. */
std::string split_glb(document &doc)
{
    const uint32_t json_chunk = 0x4e4f534a, binary_chunk = 0x004e4942;
    if (doc.file.size() < 20)
        fail(doc, HPR_ERR_FORMAT, "a GLB header takes 20 bytes, the file has %zu", doc.file.size());
    uint32_t version = little_u32(doc.file, 4);
    size_t length = little_u32(doc.file, 8);
    if (version != 2)
        fail(doc, HPR_ERR_UNSUPPORTED, "GLB version %u; hprad reads version 2", version);
    if (length > doc.file.size())
        fail(doc, HPR_ERR_FORMAT, "the GLB header says %zu bytes, the file has %zu", length, doc.file.size());
    std::string json;
    for (size_t at = 12, chunk = 0; at + 8 <= length; chunk++) {
        size_t size = little_u32(doc.file, at);
        uint32_t kind = little_u32(doc.file, at + 4);
        at += 8;
        if (size > length - at)
            fail(doc, HPR_ERR_FORMAT, "GLB chunk %zu ends %zu bytes past the end", chunk,
                 size - (length - at));
        if (chunk == 0 && kind != json_chunk)
            fail(doc, HPR_ERR_FORMAT, "the first GLB chunk is not JSON");
        if (chunk == 0)
            json.assign(reinterpret_cast<const char *>(doc.file.data()) + at, size);
        if (chunk == 1 && kind == binary_chunk) {
            doc.chunk_offset = at;
            doc.chunk_bytes = size;
        }
        at += size;
    }
    return json;
}

void parse_json(document &doc)
{
    bool binary = doc.file.size() >= 4 && std::memcmp(doc.file.data(), "glTF", 4) == 0;
    std::string text = binary ? split_glb(doc) : std::string(doc.file.begin(), doc.file.end());
    const char *start = text.c_str(), *end = start;
    if (text.compare(0, 3, "\xef\xbb\xbf") == 0)
        start += 3;
    size_t size = text.size() + 1 - static_cast<size_t>(start - text.c_str());
    doc.json.reset(cJSON_ParseWithLengthOpts(start, size, &end, true));
    if (!doc.json)
        fail(doc, HPR_ERR_FORMAT, "not JSON: the text breaks off or makes no sense at byte %zu of %zu",
             static_cast<size_t>(end - start), size - 1);
    if (!cJSON_IsObject(doc.json.get()))
        fail(doc, HPR_ERR_FORMAT, "the JSON is not an object");
}

const char *text_member(const cJSON *object, const char *key)
{
    return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, key));
}

/* Before the schema: a file of another version, or one that needs an extension, need not follow it. */
void check_version(const document &doc)
{
    const cJSON *asset = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "asset");
    const char *version = text_member(asset, "version"), *least = text_member(asset, "minVersion");
    if (!version)
        fail(doc, HPR_ERR_FORMAT, "asset.version is missing, so this is not glTF");
    if (std::strncmp(version, "2.", 2) != 0)
        fail(doc, HPR_ERR_UNSUPPORTED, "glTF version '%s'; hprad reads 2.0", version);
    if (least && std::strcmp(least, "2.0") != 0)
        fail(doc, HPR_ERR_UNSUPPORTED, "needs a reader of glTF version '%s'; hprad reads 2.0", least);
}

void check_required_extensions(const document &doc)
{
    static const char *const supported[] = {"KHR_mesh_quantization", "KHR_materials_emissive_strength",
                                            "KHR_texture_transform", "KHR_materials_unlit"};
    const cJSON *item, *list = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "extensionsRequired");
    std::string missing;
    cJSON_ArrayForEach(item, list)
    {
        const char *name = cJSON_GetStringValue(item);
        bool known = !name; /* not a text: left to the schema */
        for (const char *candidate : supported)
            known = known || std::strcmp(candidate, name) == 0;
        if (!known)
            missing += (missing.empty() ? "" : ", ") + std::string(name);
    }
    if (!missing.empty())
        fail(doc, HPR_ERR_UNSUPPORTED, "needs an extension that hprad does not have: %s", missing.c_str());
}

void write_text(const char *text, std::string &out)
{
    out += '"';
    for (const char *c = text; *c; c++) {
        if (static_cast<unsigned char>(*c) < 0x20 || *c == '"' || *c == '\\')
            out += print("\\u%04x", static_cast<unsigned>(static_cast<unsigned char>(*c)));
        else
            out += *c;
    }
    out += '"';
}

/* Integers stay integers up to 2^53, as tinygltf wants offsets; but inside extensions it would cut them to 32
 * bits, so there they become reals. */
void write_number(double value, bool extension, std::string &out)
{
    const double exact = extension ? 2147483647.0 : 9007199254740992.0;
    bool integer =
        value == std::floor(value) && std::fabs(value) <= exact && !(value == 0 && std::signbit(value));
    out += integer ? print("%.0f", value) : print("%.17e", value);
}

/* cJSON's own printer rounds to 15 digits when that comes close; this one returns every bit. */
void write_json(const cJSON *item, bool extension, std::string &out)
{
    if (cJSON_IsString(item)) {
        write_text(item->valuestring, out);
    } else if (cJSON_IsNumber(item)) {
        write_number(item->valuedouble, extension, out);
    } else if (cJSON_IsArray(item) || cJSON_IsObject(item)) {
        bool object = cJSON_IsObject(item);
        out += object ? '{' : '[';
        for (const cJSON *child = item->child, *first = child; child; child = child->next) {
            if (child != first)
                out += ',';
            if (object) {
                write_text(child->string, out);
                out += ':';
            }
            bool inside = extension || (object && std::strcmp(child->string, "extensions") == 0);
            write_json(child, inside, out);
        }
        out += object ? '}' : ']';
    } else {
        out += cJSON_IsTrue(item) ? "true" : cJSON_IsFalse(item) ? "false" : "null";
    }
}

size_t count_items(const cJSON *root, const char *key)
{
    return static_cast<size_t>(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(root, key)));
}

/* tinygltf refuses indices without a buffer view, which glTF allows: such accessors point at a stand-in
 * behind the last view. */
void add_stand_in_view(document &doc, size_t view_count)
{
    cJSON *root = doc.json.get(), *accessor;
    cJSON_ArrayForEach(accessor, cJSON_GetObjectItemCaseSensitive(root, "accessors"))
    {
        if (!cJSON_GetObjectItemCaseSensitive(accessor, "bufferView") &&
            !cJSON_AddNumberToObject(accessor, "bufferView", static_cast<double>(view_count)))
            throw std::bad_alloc();
    }
    cJSON *views = cJSON_GetObjectItemCaseSensitive(root, "bufferViews");
    if (!views)
        views = cJSON_AddArrayToObject(root, "bufferViews");
    cJSON *view = cJSON_CreateObject();
    if (!views || !cJSON_AddItemToArray(views, view) || !cJSON_AddNumberToObject(view, "buffer", 0) ||
        !cJSON_AddNumberToObject(view, "byteLength", 1))
        throw std::bad_alloc();
}

/*
 * Hands tinygltf what it is needed for. Its loading of buffers and images is left out: it reads past a buffer
 * when an image's view does not fit, refuses legal files, and goes on without a picture that is missing.
 */
void load_model(document &doc)
{
    static const char *const sections[] = {"asset",     "scene",     "scenes",   "nodes",
                                           "meshes",    "accessors", "textures", "bufferViews",
                                           "materials", "samplers",  "cameras"};
    size_t view_count = count_items(doc.json.get(), "bufferViews");
    add_stand_in_view(doc, view_count);
    std::string text = "{";
    for (const char *key : sections) {
        const cJSON *item = cJSON_GetObjectItemCaseSensitive(doc.json.get(), key);
        if (!item)
            continue;
        text += text.size() > 1 ? ",\"" : "\"";
        text += std::string(key) + "\":";
        write_json(item, false, text);
    }
    text += "}";
    if (text.size() > UINT_MAX)
        fail(doc, HPR_ERR_UNSUPPORTED, "more than 4 GiB of JSON");
    tinygltf::TinyGLTF loader;
    std::string error, warning;
    bool good = loader.LoadASCIIFromString(&doc.model, &error, &warning, text.c_str(),
                                           static_cast<unsigned>(text.size()), "");
    if (!good)
        fail(doc, HPR_ERR_FORMAT, "%s", error.c_str());
    const cJSON *root = doc.json.get();
    if (doc.model.meshes.size() != count_items(root, "meshes") ||
        doc.model.nodes.size() != count_items(root, "nodes") ||
        doc.model.accessors.size() != count_items(root, "accessors") ||
        doc.model.materials.size() != count_items(root, "materials"))
        fail(doc, HPR_ERR_FORMAT, "tinygltf dropped a part: %s", error.c_str());
    doc.model.bufferViews.resize(view_count);
    for (tinygltf::Accessor &accessor : doc.model.accessors) {
        if (accessor.bufferView == static_cast<int>(view_count))
            accessor.bufferView = -1;
    }
}

} // namespace

std::string print(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    std::string text = print_list(format, arguments);
    va_end(arguments);
    return text;
}

std::string one_line(const std::string &text)
{
    std::string out;
    for (char c : text)
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    while (!out.empty() && out.back() == ' ')
        out.pop_back();
    return out;
}

void fail(const document &doc, hpr_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    std::string text = print_list(format, arguments);
    va_end(arguments);
    throw fault(status, one_line(doc.path + ": " + text));
}

void check(hpr_status status)
{
    if (status != HPR_OK)
        throw fault(status, "");
}

std::string label(const char *kind, size_t index, const std::string &name)
{
    std::string text = print("%s %zu", kind, index);
    return name.empty() ? text : text + " '" + name.substr(0, 80) + "'";
}

bool uses_extension(const document &doc, const char *name)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(doc.json.get(), "extensionsUsed"))
    {
        if (std::strcmp(cJSON_GetStringValue(item), name) == 0)
            return true;
    }
    return false;
}

void open_document(document &doc)
{
    doc.file = read_file(doc, doc.path, "", SIZE_MAX);
    parse_json(doc);
    check_version(doc);
    check_required_extensions(doc);
    check_schema(doc);
    doc.buffer.resize(count_items(doc.json.get(), "buffers"));
    doc.quantized = uses_extension(doc, "KHR_mesh_quantization");
    load_model(doc);
    check_accessors(doc);
}

} // namespace gltf
