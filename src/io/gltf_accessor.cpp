/* Accessors: where their bytes lie, and the numbers in them. */
#include "io/gltf.hpp"

#include <cstring>

namespace gltf
{

namespace
{

/* An accessor without a view is zeros (plus sparse values): its length is bounded by nothing in the file. */
const uint64_t max_viewless_count = 1 << 24;

size_t component_bytes(int type)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        return 0;
    }
}

size_t element_bytes(const tinygltf::Accessor &a)
{
    size_t component = component_bytes(a.componentType), columns = 1, rows = 1;
    switch (a.type) {
    case TINYGLTF_TYPE_MAT2:
        columns = rows = 2;
        break;
    case TINYGLTF_TYPE_MAT3:
        columns = rows = 3;
        break;
    case TINYGLTF_TYPE_MAT4:
        columns = rows = 4;
        break;
    default:
        return component *
               static_cast<size_t>(tinygltf::GetNumComponentsInType(static_cast<uint32_t>(a.type)));
    }
    return columns * ((rows * component + 3) / 4 * 4); /* columns start at multiples of 4 bytes */
}

/* The accessor and its first user: "accessor 3 'positions' (mesh 0 'Box', primitive 1)". */
std::string accessor_label(const document &doc, size_t index)
{
    std::string text = label("accessor", index, doc.model.accessors[index].name);
    for (size_t m = 0; m < doc.model.meshes.size(); m++) {
        const tinygltf::Mesh &mesh = doc.model.meshes[m];
        for (size_t p = 0; p < mesh.primitives.size(); p++) {
            bool used = mesh.primitives[p].indices == static_cast<int>(index);
            for (const auto &attribute : mesh.primitives[p].attributes)
                used = used || attribute.second == static_cast<int>(index);
            if (used)
                return text + " (" + label("mesh", m, mesh.name) + print(", primitive %zu)", p);
        }
    }
    return text;
}

/* The schema keeps every value below 2^53 and a stride below 2^8, so that no sum here overflows. */
void check_span(const document &doc, size_t accessor, int view, uint64_t offset, uint64_t count,
                uint64_t stride, uint64_t size)
{
    const tinygltf::BufferView &v = doc.model.bufferViews[static_cast<size_t>(view)];
    uint64_t end = offset + stride * (count - 1) + size;
    if (end > v.byteLength)
        fail(doc, HPR_ERR_FORMAT, "%s reads %llu bytes past its bufferView %d of %zu bytes",
             accessor_label(doc, accessor).c_str(), static_cast<unsigned long long>(end - v.byteLength), view,
             v.byteLength);
}

void check_sparse(const document &doc, size_t index)
{
    const tinygltf::Accessor &a = doc.model.accessors[index];
    auto count = static_cast<uint64_t>(a.sparse.count);
    int type = a.sparse.indices.componentType;
    if (count > a.count)
        fail(doc, HPR_ERR_FORMAT, "%s replaces %llu of its %zu elements", accessor_label(doc, index).c_str(),
             static_cast<unsigned long long>(count), a.count);
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        fail(doc, HPR_ERR_FORMAT, "%s: sparse indices of componentType %d, not 5121, 5123 or 5125",
             accessor_label(doc, index).c_str(), type);
    check_span(doc, index, a.sparse.indices.bufferView, static_cast<uint64_t>(a.sparse.indices.byteOffset),
               count, component_bytes(type), component_bytes(type));
    check_span(doc, index, a.sparse.values.bufferView, static_cast<uint64_t>(a.sparse.values.byteOffset),
               count, element_bytes(a), element_bytes(a));
}

void check_accessor(const document &doc, size_t index)
{
    const tinygltf::Accessor &a = doc.model.accessors[index];
    size_t size = element_bytes(a);
    if (size == 0)
        fail(doc, HPR_ERR_FORMAT, "%s has the componentType %d, which glTF does not know",
             accessor_label(doc, index).c_str(), a.componentType);
    if (a.bufferView >= 0) {
        size_t stride = doc.model.bufferViews[static_cast<size_t>(a.bufferView)].byteStride;
        if (stride && stride < size)
            fail(doc, HPR_ERR_FORMAT, "%s has elements of %zu bytes, its bufferView %d a byteStride of %zu",
                 accessor_label(doc, index).c_str(), size, a.bufferView, stride);
        check_span(doc, index, a.bufferView, a.byteOffset, a.count, stride ? stride : size, size);
    } else if (a.count > max_viewless_count) {
        fail(doc, HPR_ERR_UNSUPPORTED, "%s has %zu elements and no bufferView; hprad takes up to %llu",
             accessor_label(doc, index).c_str(), a.count,
             static_cast<unsigned long long>(max_viewless_count));
    }
    if (a.sparse.isSparse)
        check_sparse(doc, index);
}

void check_views(const document &doc)
{
    const cJSON *buffer = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "buffers");
    std::vector<double> size; /* below 2^53, so a double holds it */
    for (buffer = buffer ? buffer->child : nullptr; buffer; buffer = buffer->next)
        size.push_back(cJSON_GetObjectItemCaseSensitive(buffer, "byteLength")->valuedouble);
    for (size_t i = 0; i < doc.model.bufferViews.size(); i++) {
        const tinygltf::BufferView &v = doc.model.bufferViews[i];
        auto length = static_cast<uint64_t>(size[static_cast<size_t>(v.buffer)]);
        uint64_t end = static_cast<uint64_t>(v.byteOffset) + v.byteLength;
        if (end > length)
            fail(doc, HPR_ERR_FORMAT, "%s ends %llu bytes past its buffer %d of %llu bytes",
                 label("bufferView", i, v.name).c_str(), static_cast<unsigned long long>(end - length),
                 v.buffer, static_cast<unsigned long long>(length));
    }
}

bytes load_buffer(const document &doc, size_t index)
{
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(doc.json.get(), "buffers");
    const cJSON *item = cJSON_GetArrayItem(list, static_cast<int>(index));
    const char *uri = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "uri"));
    auto length = static_cast<size_t>(cJSON_GetObjectItemCaseSensitive(item, "byteLength")->valuedouble);
    std::string what = print("buffer %zu", index);
    bytes data;
    if (uri)
        data = load_uri(doc, uri, what, length);
    else if (index != 0 || doc.chunk_bytes == 0)
        fail(doc, HPR_ERR_FORMAT, "%s has no uri, and there is no binary chunk for it", what.c_str());
    else
        data.assign(doc.file.begin() + static_cast<std::ptrdiff_t>(doc.chunk_offset),
                    doc.file.begin() + static_cast<std::ptrdiff_t>(doc.chunk_offset + doc.chunk_bytes));
    if (data.size() < length)
        fail(doc, HPR_ERR_FORMAT, "%s should have %zu bytes, but %s has %zu", what.c_str(), length,
             !uri                                 ? "the binary chunk"
             : std::strncmp(uri, "data:", 5) == 0 ? "its data URI"
                                                  : uri,
             data.size());
    return data;
}

template <typename T> double load(const unsigned char *at, double scale)
{
    T value;
    std::memcpy(&value, at, sizeof value);
    double number = static_cast<double>(value) / scale;
    return scale != 1 && number < -1 ? -1 : number; /* -128/127 counts as -1 */
}

double component(const unsigned char *at, int type, bool normalized)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return load<int8_t>(at, normalized ? 127 : 1);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load<uint8_t>(at, normalized ? 255 : 1);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return load<int16_t>(at, normalized ? 32767 : 1);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load<uint16_t>(at, normalized ? 65535 : 1);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return load<uint32_t>(at, 1);
    default:
        return load<float>(at, 1);
    }
}

struct sparse_view {
    std::vector<size_t> index;
    view values;
};

sparse_view open_sparse(document &doc, size_t accessor)
{
    const tinygltf::Accessor &a = doc.model.accessors[accessor];
    view indices = open_view(doc, a.sparse.indices.bufferView);
    auto offset = static_cast<size_t>(a.sparse.indices.byteOffset);
    int type = a.sparse.indices.componentType;
    sparse_view out;
    for (size_t i = 0; i < static_cast<size_t>(a.sparse.count); i++) {
        const unsigned char *at = indices.data + offset + i * component_bytes(type);
        auto index = static_cast<size_t>(component(at, type, false));
        if (index >= a.count || (i && index <= out.index.back()))
            fail(doc, HPR_ERR_FORMAT, "%s: sparse index %zu is %zu: not rising or not below %zu",
                 accessor_label(doc, accessor).c_str(), i, index, a.count);
        out.index.push_back(index);
    }
    view values = open_view(doc, a.sparse.values.bufferView);
    auto skip = static_cast<size_t>(a.sparse.values.byteOffset);
    out.values = {values.data + skip, values.size - skip};
    return out;
}

} // namespace

void check_accessors(const document &doc)
{
    check_views(doc);
    for (size_t i = 0; i < doc.model.accessors.size(); i++)
        check_accessor(doc, i);
}

view open_view(document &doc, int index)
{
    const tinygltf::BufferView &v = doc.model.bufferViews[static_cast<size_t>(index)];
    auto b = static_cast<size_t>(v.buffer);
    if (!doc.buffer[b])
        doc.buffer[b] = load_buffer(doc, b);
    return {doc.buffer[b]->data() + v.byteOffset, v.byteLength};
}

std::vector<double> read_numbers(document &doc, int accessor, size_t width)
{
    auto index = static_cast<size_t>(accessor);
    const tinygltf::Accessor &a = doc.model.accessors[index];
    size_t size = element_bytes(a), part = component_bytes(a.componentType);
    std::vector<double> out(a.count * width);
    if (a.bufferView >= 0) {
        view v = open_view(doc, a.bufferView);
        size_t stride = doc.model.bufferViews[static_cast<size_t>(a.bufferView)].byteStride;
        for (size_t i = 0; i < a.count; i++) {
            const unsigned char *at = v.data + a.byteOffset + i * (stride ? stride : size);
            for (size_t k = 0; k < width; k++)
                out[i * width + k] = component(at + k * part, a.componentType, a.normalized);
        }
    }
    if (a.sparse.isSparse) {
        sparse_view sparse = open_sparse(doc, index);
        for (size_t i = 0; i < sparse.index.size(); i++) {
            for (size_t k = 0; k < width; k++)
                out[sparse.index[i] * width + k] =
                    component(sparse.values.data + i * size + k * part, a.componentType, a.normalized);
        }
    }
    return out;
}

std::vector<uint32_t> read_indices(document &doc, int accessor, size_t vertex_count, const std::string &where)
{
    const tinygltf::Accessor &a = doc.model.accessors[static_cast<size_t>(accessor)];
    double restart = 0; /* the largest value of the type restarts a strip in graphics APIs; glTF forbids it */
    if (a.type == TINYGLTF_TYPE_SCALAR && !a.normalized)
        restart = a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? UINT8_MAX
                  : a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? UINT16_MAX
                  : a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT   ? UINT32_MAX
                                                                              : 0;
    if (restart == 0)
        fail(doc, HPR_ERR_FORMAT,
             "%s: indices accessor %d must be SCALAR of componentType 5121, 5123 or 5125", where.c_str(),
             accessor);
    std::vector<double> numbers = read_numbers(doc, accessor, 1);
    std::vector<uint32_t> out(numbers.size());
    for (size_t i = 0; i < numbers.size(); i++) {
        if (numbers[i] >= static_cast<double>(vertex_count) || numbers[i] == restart)
            fail(doc, HPR_ERR_FORMAT, "%s: index %zu (accessor %d) is %.0f, but there are %zu vertices%s",
                 where.c_str(), i, accessor, numbers[i], vertex_count,
                 numbers[i] == restart ? " (primitive restart is not part of glTF)" : "");
        out[i] = static_cast<uint32_t>(numbers[i]);
    }
    return out;
}

} // namespace gltf
