/* Reflectance and emission of glTF materials: factors, vertex colours, textures. */
#include "gltf_file.h"
#include "png_file.h"

#include <hprad/context.h>

#define EPS 2.220446049250313e-16
#define UNIT_SQUARE 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0

static double linear(double code)
{
    double s = code / 255;
    return s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4);
}

/* One triangle with the given material. */
static hpr_status read_material(fixture *f, const char *material, const char *more)
{
    if (!f->size)
        PUT(f, float, 0, 0, 0, 1, 0, 0, 0, 1, 0);
    return read_body(f,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0}%s}]}],"
                     "'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],"
                     "'bufferViews':[{'buffer':0,'byteLength':36}]%s%s%s%s",
                     material ? ",'material':0" : "", material ? ",'materials':[" : "",
                     material ? material : "", material ? "]" : "", more);
}

static const double *face_rho(const fixture *f, size_t face)
{
    return f->scene->face_reflectance + 3 * face;
}

static void no_material_reflects_four_fifths(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, NULL, ""));
    assert_point(face_rho(f, 0), 0.8, 0.8, 0.8, 0);
    assert_int_equal(f->scene->mesh_material[0], HPR_NONE);
}

static void default_material_is_white_and_dark(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, "{}", ""));
    assert_point(face_rho(f, 0), 1, 1, 1, 0);
    assert_point(f->scene->material_radiance, 0, 0, 0, 0);
    assert_false(f->scene->material[0].double_sided);
}

static void base_colour_factor(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, "{'pbrMetallicRoughness':{'baseColorFactor':[0.1,0.2,0.3,0.4]}}", ""));
    assert_point(face_rho(f, 0), 0.1, 0.2, 0.3, 0);
}

static void double_sided(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, "{'doubleSided':true,'name':'leaf'}", ""));
    assert_true(f->scene->material[0].double_sided);
    assert_string_equal(f->scene->material[0].name, "leaf");
}

#define METAL "{'pbrMetallicRoughness':{'baseColorFactor':[0.8,0.4,0.2,1],'metallicFactor':0.25}}"

static void metallic_part_counts_as_diffuse_and_is_named(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, METAL, ""));
    assert_point(face_rho(f, 0), 0.8, 0.4, 0.2, 0);
    assert_int_equal(count_warnings(f, "metallic part of reflectance counts as diffuse (materials: 1)"), 1);
}

static void metallic_part_can_be_black(void **state)
{
    fixture *f = *state;
    f->options.metallic_black = 1;
    assert_ok(f, read_material(f, METAL, ""));
    assert_point(face_rho(f, 0), 0.6, 0.3, 0.15, EPS);
}

static void emissive_factor_times_strength_is_radiance(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f,
                               "{'emissiveFactor':[1,0.5,0.25],'extensions':"
                               "{'KHR_materials_emissive_strength':{'emissiveStrength':5000000000}}}",
                               ",'extensionsRequired':['KHR_materials_emissive_strength']"));
    assert_point(f->scene->material_radiance, 5e9, 2.5e9, 1.25e9, 0);
}

static void largest_reflectance_scales_down(void **state)
{
    fixture *f = *state;
    f->options.max_reflectance = 0.5;
    assert_ok(f, read_material(f, "{'pbrMetallicRoughness':{'baseColorFactor':[1,0.5,0,1]}}", ""));
    assert_point(face_rho(f, 0), 0.5, 0.25, 0, EPS);
}

static void every_ignored_part_is_named_once(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f,
                               "{'alphaMode':'BLEND','normalTexture':{'index':0},'occlusionTexture':"
                               "{'index':0},'pbrMetallicRoughness':{'metallicRoughnessTexture':{'index':0}},"
                               "'extensions':{'KHR_materials_unlit':{}}}",
                               ",'textures':[{'source':0}],'images':[{'uri':'missing.png'}],"
                               "'animations':[{'channels':[],'samplers':[]}],"
                               "'extensionsUsed':['KHR_materials_unlit','EXT_thing'],"
                               "'extensionsRequired':['KHR_materials_unlit']"));
    static const char *const named[] = {"alpha modes other than OPAQUE",
                                        "normal maps",
                                        "occlusion textures",
                                        "metallic-roughness textures",
                                        "KHR_materials_unlit",
                                        "animations are",
                                        "extension EXT_thing"};
    for (size_t i = 0; i < sizeof named / sizeof *named; i++)
        assert_int_equal(count_warnings(f, named[i]), 1);
}

/* A square of two triangles with COLOR_0 as given. */
static hpr_status read_colours(fixture *f, size_t offset, int type, const char *normalized, const char *shape)
{
    return read_body(f,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'COLOR_0':1},'mode':6}]}],"
                     "'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3'},"
                     "{'bufferView':1,'componentType':%d,'count':4,'type':'%s','normalized':%s}],"
                     "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':%zu,"
                     "'byteLength':%zu}]",
                     type, shape, normalized, offset, f->size - offset);
}

static void colours_of_normalized_bytes(void **state)
{
    fixture *f = *state;
    PUT(f, float, UNIT_SQUARE);
    size_t offset =
        PUT(f, unsigned char, 255, 0, 51, 9, 255, 0, 51, 9, 255, 0, 51, 9, 255, 0, 51, 9); /* with alpha */
    assert_ok(f, read_colours(f, offset, 5121, "true", "VEC4"));
    assert_point(face_rho(f, 0), 0.8, 0, 0.8 * 0.2, EPS);
    assert_point(f->scene->colour, 1, 0, 0.2, EPS);
}

static void colours_of_normalized_shorts(void **state)
{
    fixture *f = *state;
    PUT(f, float, UNIT_SQUARE);
    size_t offset = PUT(f, unsigned short, 65535, 0, 13107, 0, 65535, 0, 13107, 0, 65535, 0, 13107, 0, 65535,
                        0, 13107, 0);
    assert_ok(f, read_colours(f, offset, 5123, "true", "VEC4"));
    assert_point(face_rho(f, 0), 0.8, 0, 0.8 * 0.2, EPS);
}

static void colours_average_over_the_face(void **state)
{
    fixture *f = *state;
    PUT(f, float, UNIT_SQUARE);
    size_t offset = PUT(f, float, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1);
    assert_ok(f, read_colours(f, offset, 5126, "false", "VEC3"));
    assert_point(face_rho(f, 0), 0.8 / 3, 0.8 / 3, 0.8 / 3, EPS);
    assert_point(face_rho(f, 1), 1.6 / 3, 0.8 / 3, 1.6 / 3, 2 * EPS);
}

/*
 * A square of two triangles (uv 0,0 1,0 1,1 / 0,0 1,1 0,1, times `scale`, plus `shift`) with a PNG on it.
 * `sampler` and `transform` are JSON members.
 */
typedef struct picture {
    unsigned width, height;
    const unsigned char *pixels; /* [height][width][3] */
    const char *sampler, *transform;
    float scale, shift;
    const char *material; /* further members */
} picture;

static hpr_status read_picture(fixture *f, const picture *p)
{
    static unsigned char png[FIXTURE_BYTES];
    size_t size = make_png(png, p->width, p->height, 8, 2, p->pixels);
    f->size = 0;
    PUT(f, float, UNIT_SQUARE);
    PUT(f, unsigned char, 0, 1, 2, 0, 2, 3);
    float a = p->shift, b = p->shift + p->scale;
    size_t uv = PUT(f, float, a, a, b, a, b, b, a, b);
    size_t image = put(f, png, size);
    return read_body(f,
                     "'meshes':[{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':2},'indices':1,"
                     "'material':0}]}],'accessors':[{'bufferView':0,'componentType':5126,'count':4,"
                     "'type':'VEC3'},{'bufferView':1,'componentType':5121,'count':6,'type':'SCALAR'},"
                     "{'bufferView':2,'componentType':5126,'count':4,'type':'VEC2'}],"
                     "'bufferViews':[{'buffer':0,'byteLength':48},{'buffer':0,'byteOffset':48,"
                     "'byteLength':6},{'buffer':0,'byteOffset':%zu,'byteLength':32},{'buffer':0,"
                     "'byteOffset':%zu,'byteLength':%zu}],'images':[{'bufferView':3}],"
                     "'textures':[{'source':0,'sampler':0}],'samplers':[{%s}],"
                     "'materials':[{'pbrMetallicRoughness':{'metallicFactor':0,'baseColorTexture':"
                     "{'index':0%s}}%s}]",
                     uv, image, size, p->sampler, p->transform ? p->transform : "",
                     p->material ? p->material : "");
}

#define NEAREST "'magFilter':9728"
#define CLAMP ",'wrapS':33071,'wrapT':33071"
#define MIRROR ",'wrapS':33648,'wrapT':33648"

static const unsigned char one_grey[] = {128, 0, 255};
/* Rows of black and white: top white, bottom black. */
static const unsigned char two_rows[] = {255, 255, 255, 255, 255, 255, 0, 0, 0, 0, 0, 0};

static void one_texel_is_decoded_from_srgb(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){1, 1, one_grey, "", NULL, 1, 0, NULL}));
    assert_point(face_rho(f, 0), linear(128), 0, 1, EPS);
}

static void nearest_texels_count_by_their_area(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, NEAREST, NULL, 1, 0, NULL}));
    /* v < 1/2 covers three quarters of the upper triangle and one quarter of the lower one. */
    assert_near(face_rho(f, 0)[0], 0.75, 8 * EPS);
    assert_near(face_rho(f, 1)[0], 0.25, 8 * EPS);
}

static void bilinear_ramp_has_its_exact_mean(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, "'magFilter':9729" CLAMP, NULL, 1, 0, NULL}));
    /* Mean of clamp(3/2 - 2v, 0, 1) over the triangle 0 <= v <= u <= 1, where v has the density 2(1 - v):
     * 7/16 + 7/24 = 35/48, from the pieces v < 1/4 and 1/4 < v < 3/4. */
    assert_near(face_rho(f, 0)[0], 35.0 / 48, 16 * EPS);
    assert_near(face_rho(f, 1)[0], 13.0 / 48, 16 * EPS);
}

static void repeated_picture_keeps_its_mean(void **state)
{
    fixture *f = *state;
    unsigned char pixels[5 * 3 * 3];
    double mean = 0;
    for (size_t i = 0; i < sizeof pixels; i++) {
        pixels[i] = (unsigned char)(37 * i);
        mean += i % 3 == 0 ? linear(pixels[i]) / 15 : 0;
    }
    assert_ok(f, read_picture(f, &(picture){5, 3, pixels, "", NULL, 4, 0.3f, NULL}));
    /* The uv square has float corners: its side is 4 to 2^-22, and so is the covered part. */
    assert_near((face_rho(f, 0)[0] + face_rho(f, 1)[0]) / 2, mean, 1e-6);
}

static void mirrored_picture_keeps_its_mean(void **state)
{
    fixture *f = *state;
    unsigned char pixels[2 * 2 * 3] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    assert_ok(f, read_picture(f, &(picture){2, 2, pixels, "'magFilter':9729" MIRROR, NULL, 2, -2, NULL}));
    for (size_t c = 0; c < 3; c++)
        assert_near((face_rho(f, 0)[c] + face_rho(f, 1)[c]) / 2, 0.5, 16 * EPS);
}

static void mirrored_rows_come_in_turned_order(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, NEAREST MIRROR, NULL, 2, 0, NULL}));
    /* White, black, black, white over quarters that cover 7, 5, 3, 1 sixteenths of the upper triangle. */
    assert_near(face_rho(f, 0)[0], 0.5, 8 * EPS);
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, NEAREST, NULL, 2, 0, NULL}));
    assert_near(face_rho(f, 0)[0], 10.0 / 16, 8 * EPS);
}

static void clamped_picture_ends_in_its_edge(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, NEAREST CLAMP, NULL, 1000, 7, NULL}));
    assert_near(face_rho(f, 0)[0], 0, 0);
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, &CLAMP[1], NULL, 1000, -1007, NULL}));
    assert_near(face_rho(f, 0)[0], 1, 8 * EPS);
}

static void degenerate_coordinates_take_one_texel(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_picture(f, &(picture){2, 2, two_rows, NEAREST, NULL, 0, 0.25f, NULL}));
    assert_near(face_rho(f, 0)[0], 1, 8 * EPS);
}

/* 97 x 95 texels, repeated 8 times: 295,000 cells on each triangle, so that a coarser level steps in. */
static void large_picture_keeps_its_mean(void **state)
{
    fixture *f = *state;
    static unsigned char pixels[97 * 95 * 3];
    double mean = 0;
    for (size_t i = 0; i < sizeof pixels; i++) {
        pixels[i] = (unsigned char)((i * i + 13 * i) >> 3);
        mean += i % 3 == 0 ? linear(pixels[i]) / (97 * 95) : 0;
    }
    assert_ok(f, read_picture(f, &(picture){97, 95, pixels, "", NULL, 8, 0, NULL}));
    /* The pyramid is float32, and eight whole periods leave only its rounding. */
    assert_near((face_rho(f, 0)[0] + face_rho(f, 1)[0]) / 2, mean, 1e-6);
}

static void texture_transform_moves_the_coordinates(void **state)
{
    fixture *f = *state;
    picture p = {2, 2, two_rows, NEAREST, ",'extensions':{'KHR_texture_transform':{'offset':[0,0.5]}}",
                 1, 0, NULL};
    assert_ok(f, read_picture(f, &p));
    assert_near(face_rho(f, 0)[0], 0.25, 8 * EPS);
    assert_near(f->scene->uv[2 * 2 + 1], 1.5, 0);
}

static void texture_transform_scales_then_turns(void **state)
{
    fixture *f = *state;
    picture p = {2,
                 2,
                 two_rows,
                 NEAREST,
                 ",'extensions':{'KHR_texture_transform':{'rotation':1.5707963267948966,'scale':[2,3]}}",
                 1,
                 0,
                 NULL};
    assert_ok(f, read_picture(f, &p));
    /* (1,1) is scaled to (2,3) and turned counter-clockwise, v pointing down: (3,-2). */
    assert_near(f->scene->uv[2 * 2], 3, 4 * EPS);
    assert_near(f->scene->uv[2 * 2 + 1], -2, 4 * EPS);
}

static void an_emissive_texture_is_handed_on(void **state)
{
    fixture *f = *state;
    picture p = {2, 2, two_rows, "", NULL, 1, 0, ",'emissiveFactor':[1,0.5,0],'emissiveTexture':{'index':0}"};
    assert_ok(f, read_picture(f, &p));
    assert_int_equal(f->scene->texture_count, 1);
    assert_int_equal(f->scene->mesh_glow_texture[0], 0);
    assert_point(f->scene->mesh_glow_factor, 1, 0.5, 0, 0);
    const double *radiance = f->scene->face_radiance; /* of two faces, one white half and one black half */
    assert_near((radiance[0] + radiance[3]) / 2, 0.5, 16 * EPS);
    assert_near((radiance[1] + radiance[4]) / 2, 0.25, 16 * EPS);
    assert_near(f->scene->glow_uv[2 * 2], 1, 0);
}

static void untextured_meshes_have_no_coordinates(void **state)
{
    fixture *f = *state;
    assert_ok(f, read_material(f, "{}", ""));
    assert_true(isnan(f->scene->uv[0]));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, fixture_setup, fixture_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(no_material_reflects_four_fifths),
        TEST(default_material_is_white_and_dark),
        TEST(base_colour_factor),
        TEST(double_sided),
        TEST(metallic_part_counts_as_diffuse_and_is_named),
        TEST(metallic_part_can_be_black),
        TEST(emissive_factor_times_strength_is_radiance),
        TEST(largest_reflectance_scales_down),
        TEST(every_ignored_part_is_named_once),
        TEST(colours_of_normalized_bytes),
        TEST(colours_of_normalized_shorts),
        TEST(colours_average_over_the_face),
        TEST(one_texel_is_decoded_from_srgb),
        TEST(nearest_texels_count_by_their_area),
        TEST(bilinear_ramp_has_its_exact_mean),
        TEST(repeated_picture_keeps_its_mean),
        TEST(mirrored_picture_keeps_its_mean),
        TEST(mirrored_rows_come_in_turned_order),
        TEST(clamped_picture_ends_in_its_edge),
        TEST(degenerate_coordinates_take_one_texel),
        TEST(large_picture_keeps_its_mean),
        TEST(texture_transform_moves_the_coordinates),
        TEST(texture_transform_scales_then_turns),
        TEST(an_emissive_texture_is_handed_on),
        TEST(untextured_meshes_have_no_coordinates),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
