// Plays HailoRT 4.x: the functions of its C interface that 3we calls, with the same signatures. What a Hailo would
// compute, the Python class `Encoder` of `hailort.py` does, in this process, by onnxruntime.
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef int hailo_status;
typedef struct {
  uint32_t major, minor, revision;
} hailo_version_t;
typedef struct {
  int type, order, flags;
} hailo_format_t;
typedef struct {
  char name[128];
  struct {
    hailo_format_t user_buffer_format;
    uint32_t timeout_ms, queue_size, stats, pipeline_stats;
  } params;
} params_by_name_t;  // of inputs and of outputs

enum {
  SUCCESS = 0,
  TIMEOUT = 4,
  INVALID_OPERATION = 6,
  INSUFFICIENT_BUFFER = 8,
  INVALID_HEF = 26,
  OUT_OF_PHYSICAL_DEVICES = 74
};
enum { UINT8 = 1, FLOAT32 = 3 };

static PyObject* encoder;  // of the file that was opened last
static PyObject* picture;  // that was written last
static bool is_configured;
static int opened;  // vdevices, files and streams

static PyObject* ask(const char* what, PyObject* argument) {
  PyObject* answer = PyObject_CallMethod(encoder, what, argument ? "O" : NULL, argument);
  if (!answer) PyErr_Clear();
  return answer;
}

static size_t size_of(const char* what) {
  PyGILState_STATE state = PyGILState_Ensure();
  PyObject* size = ask(what, NULL);
  const size_t bytes = size ? PyLong_AsSize_t(size) : 0;
  Py_XDECREF(size);
  PyGILState_Release(state);
  return bytes;
}

hailo_status hailo_get_library_version(hailo_version_t* version) {
  const char* other = getenv("PLAYED_HAILORT_MAJOR");
  *version = (hailo_version_t){other ? (uint32_t)atoi(other) : 4, 20, 0};
  return SUCCESS;
}

const char* hailo_get_status_message(hailo_status status) {
  return status == TIMEOUT                   ? "HAILO_TIMEOUT"
         : status == INVALID_HEF             ? "HAILO_INVALID_HEF"
         : status == OUT_OF_PHYSICAL_DEVICES ? "HAILO_OUT_OF_PHYSICAL_DEVICES"
                                             : "HAILO_OTHER";
}

hailo_status hailo_create_vdevice(void* params, void** vdevice) {
  if (opened) return OUT_OF_PHYSICAL_DEVICES;  // there is one
  *vdevice = &encoder;
  ++opened;
  return params ? INVALID_OPERATION : SUCCESS;
}

hailo_status hailo_create_hef_file(void** hef, const char* file_name) {
  PyGILState_STATE state = PyGILState_Ensure();
  PyObject* module = PyImport_ImportModule("ai.hailort");
  encoder = module ? PyObject_CallMethod(module, "Encoder", "s", file_name) : NULL;
  if (!encoder) PyErr_Clear();
  Py_XDECREF(module);
  PyGILState_Release(state);
  *hef = encoder;
  if (encoder) ++opened;
  return encoder ? SUCCESS : INVALID_HEF;
}

hailo_status hailo_configure_vdevice(void* vdevice, void* hef, void* params, void** groups, size_t* count) {
  if (vdevice != &encoder || hef != encoder || params || *count < 1) return INVALID_OPERATION;
  groups[0] = &is_configured;
  *count = 1;
  is_configured = true;
  return SUCCESS;
}

static hailo_status make(void* group, int type, int wanted, params_by_name_t* params, size_t* count) {
  if (group != &is_configured || !is_configured) return INVALID_OPERATION;
  if (*count < 1) return INSUFFICIENT_BUFFER;
  memset(params, 0, sizeof *params);
  strcpy(params->name, wanted == UINT8 ? "encoder/input_layer1" : "encoder/conv20");
  params->params.user_buffer_format.type = type;
  *count = 1;
  return type == wanted ? SUCCESS : INVALID_OPERATION;
}
hailo_status hailo_make_input_vstream_params(void* group, bool unused, int type, params_by_name_t* p, size_t* n) {
  (void)unused;
  return make(group, type, UINT8, p, n);
}
hailo_status hailo_make_output_vstream_params(void* group, bool unused, int type, params_by_name_t* p, size_t* n) {
  (void)unused;
  return make(group, type, FLOAT32, p, n);
}

static hailo_status create(const params_by_name_t* params, size_t count, int wanted, void** streams) {
  if (count != 1 || params->params.user_buffer_format.type != wanted) return INVALID_OPERATION;
  streams[0] = wanted == UINT8 ? (void*)&picture : (void*)&encoder;
  ++opened;
  return SUCCESS;
}
static hailo_status release(bool right) {
  if (right) --opened;
  return right ? SUCCESS : INVALID_OPERATION;
}
hailo_status hailo_release_input_vstreams(void* const* streams, size_t count) {
  return release(count == 1 && streams[0] == &picture);
}
hailo_status hailo_release_output_vstreams(void* const* streams, size_t count) {
  return release(count == 1 && streams[0] == &encoder);
}
hailo_status hailo_release_hef(void* hef) { return release(hef == encoder); }
hailo_status hailo_release_vdevice(void* vdevice) { return release(vdevice == &encoder); }
hailo_status hailo_create_input_vstreams(void* group, const params_by_name_t* params, size_t count, void** streams) {
  return group == &is_configured ? create(params, count, UINT8, streams) : INVALID_OPERATION;
}
hailo_status hailo_create_output_vstreams(void* group, const params_by_name_t* params, size_t count, void** streams) {
  return group == &is_configured ? create(params, count, FLOAT32, streams) : INVALID_OPERATION;
}

hailo_status hailo_get_input_vstream_frame_size(void* stream, size_t* size) {
  *size = size_of("picture_bytes");
  return stream == &picture ? SUCCESS : INVALID_OPERATION;
}
hailo_status hailo_get_output_vstream_frame_size(void* stream, size_t* size) {
  *size = size_of("feature_bytes");
  return stream == &encoder ? SUCCESS : INVALID_OPERATION;
}

hailo_status hailo_vstream_write_raw_buffer(void* stream, const void* buffer, size_t size) {
  if (stream != &picture || size != size_of("picture_bytes")) return INVALID_OPERATION;
  PyGILState_STATE state = PyGILState_Ensure();
  Py_XDECREF(picture);
  picture = PyBytes_FromStringAndSize(buffer, (Py_ssize_t)size);
  PyGILState_Release(state);
  return SUCCESS;
}

hailo_status hailo_vstream_read_raw_buffer(void* stream, void* buffer, size_t size) {
  if (stream != &encoder || !picture || getenv("PLAYED_HAILORT_HANGS")) return TIMEOUT;
  PyGILState_STATE state = PyGILState_Ensure();
  PyObject* features = ask("features", picture);
  const bool fits = features && (size_t)PyBytes_Size(features) == size;
  if (fits) memcpy(buffer, PyBytes_AsString(features), size);
  Py_XDECREF(features);
  PyGILState_Release(state);
  return fits ? SUCCESS : INVALID_OPERATION;
}
