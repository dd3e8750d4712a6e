/* hpr_scene_read: the border between C and the C++ that reads glTF. */
#include "io/gltf.hpp"

#include <new>
#include <stdexcept>

namespace
{

/* What the file is read for. */
enum class part { all, cameras };

/* On return the scene is complete, or an exception is on its way and `scene` holds what there is of it. */
void read_scene(hpr_context *ctx, const char *path, const hpr_read_options &options, part wanted,
                hpr_scene *&scene)
{
    gltf::document doc;
    doc.context = ctx;
    doc.path = path;
    gltf::open_document(doc);
    gltf::check(hpr_scene_create(ctx, path, 3, nullptr, &scene));
    std::vector<gltf::placed_node> nodes = gltf::place_nodes(doc, options);
    if (wanted == part::cameras) {
        gltf::add_cameras(doc, nodes, scene);
        return;
    }
    gltf::texture_set textures(doc);
    std::vector<gltf::material_use> materials = gltf::add_materials(doc, textures, options, scene);
    gltf::add_meshes(doc, textures, materials, nodes, scene);
    gltf::add_cameras(doc, nodes, scene);
    gltf::warn_ignored(doc, options);
    if (options.max_reflectance > 0)
        gltf::check(hpr_scene_limit_reflectance(scene, options.max_reflectance));
}

hpr_status check_options(hpr_context *ctx, const char *path, const hpr_read_options &options)
{
    if (!path || !path[0])
        return hpr_fail(ctx, HPR_ERR_ARG, "no file name for a scene to read");
    if (options.scene_index < -1)
        return hpr_fail(ctx, HPR_ERR_ARG, "%s: scene %d is asked for; -1 means the default", path,
                        options.scene_index);
    if (!(options.max_reflectance >= 0 && options.max_reflectance <= 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "the largest reflectance must be in (0, 1], not %g",
                        options.max_reflectance);
    return HPR_OK;
}

hpr_status read(hpr_context *ctx, const char *path, const hpr_read_options *options, part wanted,
                hpr_scene **out)
{
    hpr_read_options chosen;
    hpr_read_options_init(&chosen);
    if (options)
        chosen = *options;
    *out = nullptr;
    hpr_context_clear_error(ctx);
    hpr_status status = check_options(ctx, path, chosen);
    if (status != HPR_OK)
        return status;
    hpr_scene *scene = nullptr;
    try {
        read_scene(ctx, path, chosen, wanted, scene);
    } catch (const gltf::fault &f) {
        status = f.text.empty() ? f.status : hpr_fail(ctx, f.status, "%s", f.text.c_str());
    } catch (const std::bad_alloc &) {
        status = hpr_fail(ctx, HPR_ERR_MEMORY, "%s: out of memory", path);
    } catch (const std::length_error &) {
        status = hpr_fail(ctx, HPR_ERR_MEMORY, "%s: out of memory", path);
    } catch (const std::exception &e) {
        status = hpr_fail(ctx, HPR_ERR_IO, "%s: %s", path, gltf::one_line(e.what()).c_str());
    } catch (...) {
        status = hpr_fail(ctx, HPR_ERR_IO, "%s: unknown exception", path);
    }
    if (status != HPR_OK)
        hpr_scene_destroy(&scene);
    *out = scene;
    return status;
}

} // namespace

extern "C" hpr_status hpr_scene_read(hpr_context *ctx, const char *path, const hpr_read_options *options,
                                     hpr_scene **out)
{
    return read(ctx, path, options, part::all, out);
}

extern "C" hpr_status hpr_scene_read_cameras(hpr_context *ctx, const char *path,
                                             const hpr_read_options *options, hpr_scene **out)
{
    return read(ctx, path, options, part::cameras, out);
}
