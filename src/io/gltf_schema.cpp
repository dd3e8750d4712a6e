/*
 * The part of the glTF 2.0 schema that hprad relies on, as a table. tinygltf takes a member of the wrong type
 * for an absent one and truncates large integers, so nothing reaches it that is not checked here. Members
 * that the table does not name (extras, unknown extensions) may be anything.
 */
#include "io/gltf.hpp"

#include <cfloat>
#include <climits>
#include <cmath>
#include <cstring>

namespace gltf
{

namespace
{

/* An `extensions` member is an object of objects, whose known members follow `inner`. */
enum class kind { flag, integer, number, text, index, list, object, map, extensions };

struct rule {
    const char *key;
    kind what;
    bool required = false;
    double low = -DBL_MAX, high = DBL_MAX; /* of a number */
    int least = 0, most = INT_MAX;         /* items of a list */
    std::vector<rule> inner = {};          /* list: its item; object: its members; map: its value */
    const char *target = nullptr;          /* index: the array it points into */
};

const double large = 9007199254740992.0; /* 2^53: sums and products with a stride fit into 64 bits */

rule need(rule r)
{
    r.required = true;
    return r;
}

rule flag(const char *key)
{
    return {key, kind::flag};
}

rule text(const char *key)
{
    return {key, kind::text};
}

rule integer(const char *key, double low = INT_MIN, double high = INT_MAX)
{
    return {key, kind::integer, false, low, high};
}

rule number(const char *key, double low = -DBL_MAX, double high = DBL_MAX)
{
    return {key, kind::number, false, low, high};
}

rule index(const char *key, const char *target)
{
    return {key, kind::index, false, 0, INT_MAX, 0, INT_MAX, {}, target};
}

rule list(const char *key, rule item, int least = 0, int most = INT_MAX)
{
    return {key, kind::list, false, 0, 0, least, most, {item}};
}

rule object(const char *key, std::vector<rule> members)
{
    return {key, kind::object, false, 0, 0, 0, 0, members};
}

rule extensions(std::vector<rule> members = {})
{
    return {"extensions", kind::extensions, false, 0, 0, 0, 0, members};
}

rule numbers(const char *key, int count)
{
    return list(key, number(""), count, count);
}

rule texture(const char *key, const char *strength = "")
{
    rule transform = object("KHR_texture_transform", {numbers("offset", 2), number("rotation"),
                                                      numbers("scale", 2), integer("texCoord", 0)});
    return object(key, {need(index("index", "textures")), integer("texCoord", 0), number(strength),
                        extensions({transform})});
}

std::vector<rule> material_rules()
{
    rule pbr = object("pbrMetallicRoughness", {numbers("baseColorFactor", 4), texture("baseColorTexture"),
                                               number("metallicFactor", 0, 1), number("roughnessFactor"),
                                               texture("metallicRoughnessTexture"), extensions()});
    rule strength = object("KHR_materials_emissive_strength", {number("emissiveStrength", 0)});
    return {text("name"),
            pbr,
            texture("normalTexture", "scale"),
            texture("occlusionTexture", "strength"),
            texture("emissiveTexture"),
            numbers("emissiveFactor", 3),
            text("alphaMode"),
            number("alphaCutoff"),
            flag("doubleSided"),
            extensions({strength, object("KHR_materials_unlit", {})})};
}

std::vector<rule> accessor_rules()
{
    rule indices = object("indices", {need(index("bufferView", "bufferViews")), integer("byteOffset", 0),
                                      need(integer("componentType"))});
    rule values = object("values", {need(index("bufferView", "bufferViews")), integer("byteOffset", 0)});
    rule sparse = object("sparse", {need(integer("count", 1)), need(indices), need(values)});
    return {text("name"),
            index("bufferView", "bufferViews"),
            integer("byteOffset", 0, large),
            need(integer("componentType")),
            flag("normalized"),
            need(integer("count", 1, large)),
            need(text("type")),
            list("min", number("")),
            list("max", number("")),
            sparse,
            extensions()};
}

std::vector<rule> mesh_rules()
{
    rule attributes = {"attributes", kind::map, true, 0, 0, 0, 0, {index("", "accessors")}};
    rule target = {"", kind::map, false, 0, 0, 0, 0, {index("", "accessors")}};
    rule primitive = object("", {attributes, index("indices", "accessors"), index("material", "materials"),
                                 integer("mode", 0, 6), list("targets", target), extensions()});
    return {text("name"), need(list("primitives", primitive, 1)), list("weights", number("")), extensions()};
}

std::vector<rule> camera_rules()
{
    rule perspective = object("perspective", {number("aspectRatio", DBL_MIN), need(number("yfov", DBL_MIN)),
                                              need(number("znear", DBL_MIN)), number("zfar", DBL_MIN)});
    rule orthographic = object("orthographic", {need(number("xmag")), need(number("ymag")),
                                                need(number("znear", 0)), need(number("zfar", DBL_MIN))});
    return {text("name"), need(text("type")), perspective, orthographic, extensions()};
}

std::vector<rule> node_rules()
{
    return {text("name"),
            index("camera", "cameras"),
            index("mesh", "meshes"),
            index("skin", "skins"),
            list("children", index("", "nodes")),
            numbers("matrix", 16),
            numbers("translation", 3),
            numbers("rotation", 4),
            numbers("scale", 3),
            list("weights", number("")),
            extensions()};
}

rule objects(const char *key, std::vector<rule> members)
{
    return list(key, object("", members));
}

std::vector<rule> document_rules()
{
    return {
        need(object("asset", {need(text("version")), text("minVersion")})),
        list("extensionsUsed", text("")),
        list("extensionsRequired", text("")),
        index("scene", "scenes"),
        objects("scenes", {text("name"), list("nodes", index("", "nodes")), extensions()}),
        objects("nodes", node_rules()),
        objects("meshes", mesh_rules()),
        objects("accessors", accessor_rules()),
        objects("bufferViews", {text("name"), need(index("buffer", "buffers")),
                                integer("byteOffset", 0, large), need(integer("byteLength", 1, large)),
                                integer("byteStride", 4, 252), integer("target"), extensions()}),
        objects("buffers", {text("name"), text("uri"), need(integer("byteLength", 1, large)), extensions()}),
        objects("materials", material_rules()),
        objects("textures",
                {text("name"), index("sampler", "samplers"), index("source", "images"), extensions()}),
        objects("images", {text("name"), text("uri"), text("mimeType"), index("bufferView", "bufferViews"),
                           extensions()}),
        objects("samplers", {text("name"), integer("magFilter"), integer("minFilter"), integer("wrapS"),
                             integer("wrapT"), extensions()}),
        objects("cameras", camera_rules()),
        objects("skins", {text("name"), index("skeleton", "nodes"), index("inverseBindMatrices", "accessors"),
                          list("joints", index("", "nodes"))}),
        objects("animations", {text("name")}),
        extensions()};
}

std::string show(const cJSON *item)
{
    if (cJSON_IsNumber(item))
        return print("%.17g", item->valuedouble);
    if (cJSON_IsString(item))
        return "\"" + std::string(item->valuestring).substr(0, 40) + "\"";
    if (cJSON_IsArray(item))
        return print("an array of %d", cJSON_GetArraySize(item));
    return cJSON_IsObject(item) ? "an object" : cJSON_IsBool(item) ? "true or false" : "null";
}

class checker
{
  public:
    explicit checker(const document &doc) : doc(doc)
    {
        /* Array lengths by name: cJSON would walk the list for every index. */
        for (const cJSON *item = doc.json->child; item; item = item->next) {
            if (cJSON_IsArray(item))
                counts.emplace_back(item->string, cJSON_GetArraySize(item));
        }
    }

    void check_members(const cJSON *item, const std::vector<rule> &rules, const std::string &where)
    {
        for (const rule &r : rules) {
            const cJSON *found = nullptr;
            for (const cJSON *child = item->child; child; child = child->next) {
                if (std::strcmp(child->string, r.key) != 0)
                    continue;
                if (found)
                    fail(doc, HPR_ERR_FORMAT, "%s stands there twice", join(where, r.key).c_str());
                found = child;
                check(child, r, join(where, r.key));
            }
            if (r.required && !found)
                fail(doc, HPR_ERR_FORMAT, "%s is missing", join(where, r.key).c_str());
        }
    }

  private:
    const document &doc;
    std::vector<std::pair<std::string, int>> counts;

    static std::string join(const std::string &where, const char *key)
    {
        if (where.empty())
            return key;
        bool element = where.back() == '\'' || std::isdigit(static_cast<unsigned char>(where.back()));
        return where + (element ? ": " : ".") + key;
    }

    /* Elements of the top-level arrays are "node 3 'Lamp'", deeper ones "primitives[2]". */
    static std::string element(const std::string &where, int i, const cJSON *item)
    {
        if (where.find_first_of(".: [") != std::string::npos)
            return where + print("[%d]", i);
        const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "name"));
        bool plural = !where.empty() && where.back() == 's';
        size_t cut = where == "meshes" ? 2 : plural ? 1 : 0;
        return label(where.substr(0, where.size() - cut).c_str(), static_cast<size_t>(i), name ? name : "");
    }

    [[noreturn]] void refuse(const cJSON *item, const std::string &where, const std::string &expected)
    {
        fail(doc, HPR_ERR_FORMAT, "%s must be %s, not %s", where.c_str(), expected.c_str(),
             show(item).c_str());
    }

    void check_number(const cJSON *item, const rule &r, const std::string &where)
    {
        bool integral = r.what != kind::number;
        double value = cJSON_IsNumber(item) ? item->valuedouble : NAN, high = r.high;
        int count = 0;
        if (r.what == kind::index) {
            for (const auto &entry : counts)
                count = entry.first == r.target ? entry.second : count;
            high = count - 1;
        }
        if (std::isfinite(value) && value >= r.low && value <= high &&
            (!integral || value == std::floor(value)))
            return;
        if (r.what == kind::index)
            refuse(item, where, print("an index into %s (there are %d)", r.target, count));
        std::string range = r.low > INT_MIN ? print(" of at least %g", r.low) : "";
        if (r.low > INT_MIN && high < INT_MAX)
            range = print(" in %g .. %g", r.low, high);
        refuse(item, where, (integral ? "an integer" : "a finite number") + range);
    }

    void check_list(const cJSON *item, const rule &r, const std::string &where)
    {
        if (!cJSON_IsArray(item))
            refuse(item, where, "an array");
        int count = cJSON_GetArraySize(item), i = 0;
        if (count < r.least || count > r.most)
            fail(doc, HPR_ERR_FORMAT, "%s must have %s%d items, not %d", where.c_str(),
                 r.least == r.most ? "" : "at least ", r.least, count);
        for (const cJSON *child = item->child; child; child = child->next, i++) {
            bool scalar = cJSON_IsNumber(child); /* most items are: no text is made for them */
            bool simple = scalar && r.inner[0].what == kind::number && std::isfinite(child->valuedouble);
            if (!simple)
                check(child, r.inner[0], element(where, i, child));
        }
    }

    void check_object(const cJSON *item, const rule &r, const std::string &where)
    {
        if (!cJSON_IsObject(item))
            refuse(item, where, "an object");
        for (const cJSON *child = item->child; child; child = child->next) {
            if (r.what == kind::map)
                check(child, r.inner[0], join(where, child->string));
            else if (r.what == kind::extensions && !cJSON_IsObject(child))
                refuse(child, join(where, child->string), "an object");
        }
        if (r.what != kind::map)
            check_members(item, r.inner, where);
    }

    void check(const cJSON *item, const rule &r, const std::string &where)
    {
        switch (r.what) {
        case kind::flag:
            if (!cJSON_IsBool(item))
                refuse(item, where, "true or false");
            break;
        case kind::text:
            if (!cJSON_IsString(item))
                refuse(item, where, "a string");
            break;
        case kind::integer:
        case kind::number:
        case kind::index:
            check_number(item, r, where);
            break;
        case kind::list:
            check_list(item, r, where);
            break;
        case kind::object:
        case kind::map:
        case kind::extensions:
            check_object(item, r, where);
            break;
        }
    }
};

} // namespace

void check_schema(const document &doc)
{
    checker(doc).check_members(doc.json.get(), document_rules(), "");
}

} // namespace gltf
