#include "io/glb.h"

#include "io/json_text.h"
#include "io_support.h"

/* A file with the views "12345678" and "abc". */
static unsigned char *small_file(fixture *f, size_t *bytes)
{
    hpr_glb_builder builder;
    size_t index;
    hpr_glb_builder_init(f->context, &builder);
    hpr_json_text(builder.root, "x", "y", &builder.ok);
    assert_int_equal(hpr_glb_add_view(&builder, "12345678", 8, HPR_GLB_NO_TARGET, &index), HPR_OK);
    assert_int_equal(index, 0);
    assert_int_equal(hpr_glb_add_view(&builder, "abc", 3, HPR_GLB_VERTICES, &index), HPR_OK);
    assert_int_equal(index, 1);
    assert_int_equal(hpr_glb_write(&builder, in_folder(f, "a.glb")), HPR_OK);
    hpr_glb_builder_fini(&builder);
    return slurp(in_folder(f, "a.glb"), bytes);
}

static void views_come_back(void **state)
{
    fixture *f = *state;
    size_t bytes, length;
    unsigned char *data = small_file(f, &bytes);
    const unsigned char *view;
    hpr_glb glb;
    assert_int_equal(hpr_glb_read(f->context, in_folder(f, "a.glb"), &glb), HPR_OK);
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(glb.root, "x")), "y");
    assert_int_equal(hpr_glb_view(&glb, 0, &view, &length), HPR_OK);
    assert_int_equal((view - glb.data) % 8, 0); /* aligned in the file */
    assert_int_equal(length, 8);
    assert_memory_equal(view, "12345678", 8);
    assert_int_equal(hpr_glb_view(&glb, 1, &view, &length), HPR_OK);
    assert_int_equal(length, 3);
    assert_memory_equal(view, "abc", 3);
    assert_int_equal(hpr_glb_view(&glb, 2, &view, &length), HPR_ERR_FORMAT);
    assert_int_equal(bytes % 4, 0);
    hpr_glb_fini(&glb);
    free(data);
}

/* Changes `from` to `to`, of the same length, and reads the file and its view 1. */
static hpr_status read_changed(fixture *f, const char *from, const char *to)
{
    size_t bytes, length = strlen(from);
    assert_int_equal(length, strlen(to));
    unsigned char *data = small_file(f, &bytes);
    bool found = false;
    for (size_t i = 0; i + length <= bytes && !found; i++) {
        found = !memcmp(data + i, from, length);
        if (found)
            memcpy(data + i, to, length);
    }
    assert_true(found);
    spill(in_folder(f, "b.glb"), data, bytes);
    free(data);
    hpr_glb glb;
    const unsigned char *view;
    hpr_context_clear_error(f->context);
    hpr_status status = hpr_glb_read(f->context, in_folder(f, "b.glb"), &glb);
    if (status == HPR_OK)
        status = hpr_glb_view(&glb, 1, &view, &length);
    hpr_glb_fini(&glb);
    return status;
}

static void views_stay_inside(void **state)
{
    fixture *f = *state;
    assert_int_equal(read_changed(f, "\"byteLength\":3", "\"byteLength\":4"), HPR_OK); /* the padding */
    assert_int_equal(read_changed(f, "\"byteOffset\":8", "\"byteOffset\":9"), HPR_OK);
    static const char *const cases[][3] = {
        {"\"byteLength\":3", "\"byteLength\":5", "leaves the binary chunk"},
        {"\"byteOffset\":8,\"byteLength\":3", "\"byteOffset\":9,\"byteLength\":4", "leaves the binary chunk"},
        {"\"byteLength\":3", "\"byteLengtH\":3", "buffer view 1 is missing or broken"},
        {"0,\"byteOffset\":8", "1,\"byteOffset\":8", "buffer view 1 is missing or broken"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_int_equal(read_changed(f, cases[i][0], cases[i][1]), HPR_ERR_FORMAT);
        assert_message_has(f, "b.glb");
        assert_message_has(f, cases[i][2]);
    }
}

static void broken_containers_are_refused(void **state)
{
    fixture *f = *state;
    assert_int_equal(read_changed(f, "glTF\2", "glTF\1"), HPR_ERR_FORMAT);
    assert_message_has(f, "version 1");
    assert_int_equal(read_changed(f, "JSON", "JSOM"), HPR_ERR_FORMAT);
    assert_message_has(f, "chunk 0");
    assert_int_equal(read_changed(f, "\"y\"", "\"y,"), HPR_ERR_FORMAT);
    assert_message_has(f, "broken at byte");
    /* a text that ends the JSON early */
    size_t bytes;
    unsigned char *data = small_file(f, &bytes);
    data[21] = 0;
    spill(in_folder(f, "b.glb"), data, bytes);
    hpr_glb glb;
    assert_int_equal(hpr_glb_read(f->context, in_folder(f, "b.glb"), &glb), HPR_ERR_FORMAT);
    hpr_glb_fini(&glb);
    /* the binary chunk's length */
    free(data);
    data = small_file(f, &bytes);
    size_t chunk = 20 + (size_t)data[12] + 256u * data[13];
    assert_memory_equal(data + chunk + 4, "BIN", 4);
    for (int wrong = 0; wrong < 256; wrong++) {
        if (wrong == 12)
            continue;
        data[chunk] = (unsigned char)wrong;
        spill(in_folder(f, "b.glb"), data, bytes);
        assert_int_equal(hpr_glb_read(f->context, in_folder(f, "b.glb"), &glb), HPR_ERR_FORMAT);
        hpr_glb_fini(&glb);
    }
    free(data);
}

static void numbers_round_trip(void **state)
{
    (void)state;
    uint64_t seed = 77;
    for (int i = 0; i < 100000; i++) {
        uint64_t bits = random_bits(&seed);
        double value, back = 0;
        memcpy(&value, &bits, sizeof value);
        if (isnan(value))
            continue;
        bool ok = true;
        cJSON *array = cJSON_CreateArray();
        hpr_json_exact(array, NULL, value, &ok);
        char *text = cJSON_PrintUnformatted(array);
        cJSON *parsed = cJSON_Parse(text);
        assert_true(ok && hpr_json_read_exact(cJSON_GetArrayItem(parsed, 0), &back));
        assert_memory_equal(&value, &back, sizeof value);
        cJSON_Delete(parsed);
        cJSON_Delete(array);
        cJSON_free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {IO_TEST(views_come_back), IO_TEST(views_stay_inside),
                                       IO_TEST(broken_containers_are_refused), IO_TEST(numbers_round_trip)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
