#ifndef SIMULI_H
#define SIMULI_H
/* The main calls for C and for languages that bind to C. No exception crosses: a call that can fail returns a
 * simuli_status, and simuli_error() tells what went wrong. Handles are opaque; close functions take NULL too.
 * A device, and the scenes opened on it, are used by one thread at a time. Metres, seconds, radians;
 * right-handed frames: world z up; LiDARs x forward, y left, z up; cameras x right, y down, z forward. */
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum simuli_status { /* also the exit codes of the program */
                             SIMULI_OK = 0,
                             SIMULI_USAGE = 2,  /* an argument that is not allowed */
                             SIMULI_INPUT = 3,  /* a file that is missing or not as it should be */
                             SIMULI_DEVICE = 4, /* no such OpenCL device, or it failed */
                             SIMULI_KERNEL = 5,
                             SIMULI_NUMERIC = 6,
                             SIMULI_INTERNAL = 70
} simuli_status;

typedef struct simuli_device simuli_device;
typedef struct simuli_scene simuli_scene;

/* p_a = rotate(rotation_wxyz, p_b) + position_m; any quaternion but zero. */
typedef struct simuli_pose {
  double position_m[3];
  double rotation_wxyz[4];
} simuli_pose;

/* Where a sensor is, and when, while it takes one frame. */
typedef struct simuli_shot {
  simuli_pose world_from_sensor_start;
  simuli_pose world_from_sensor_end;
  double time_start_s; /* of the scene's log */
  double time_end_s;   /* equal to the start: an instant (cameras with a global shutter) */
} simuli_shot;

typedef struct simuli_sensor {
  const char* name; /* lives as long as the scene */
  int is_camera;    /* 0: a LiDAR */
  size_t columns;   /* pixels, or rays of a beam */
  size_t rows;      /* pixels, or beams */
  simuli_pose rig_from_sensor;
} simuli_sensor;

/* "0.1.0" */
const char* simuli_version(void);
/* What the last failed call of this thread said, one line; "" when none has failed. */
const char* simuli_error(void);

/* request: part of "platform / device", or its index; NULL or "": the first usable one. */
simuli_status simuli_device_open(const char* request, simuli_device** device);
const char* simuli_device_name(const simuli_device* device);
void simuli_device_close(simuli_device* device);

/* Reads a scene folder. The scene keeps its device: that may be closed at once. */
simuli_status simuli_scene_open(const simuli_device* device, const char* folder, simuli_scene** scene);
void simuli_scene_close(simuli_scene* scene);

/* The sensors that the scene was trained on: index 0 to count - 1. */
size_t simuli_scene_sensor_count(const simuli_scene* scene);
simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor);
/* Mounts a built-in LiDAR ("hesai_pandar128") or one from a LiDAR file as one more sensor of the scene. */
simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const char* name_or_file,
                                     const simuli_pose* rig_from_sensor);
/* First and last time of the recorded path. */
simuli_status simuli_scene_span(const simuli_scene* scene, double* start_s, double* end_s);
/* Where sensor `name` is on the recorded path from time_start_s to time_end_s. */
simuli_status simuli_scene_shot(
    const simuli_scene* scene, const char* name, double time_start_s, double time_end_s, simuli_shot* shot);

/* rgb[rows][columns][3] in [0, 1]; `values` is its length: SIMULI_USAGE when that is another one. */
simuli_status simuli_render_camera(
    simuli_scene* scene, const char* name, const simuli_shot* shot, float* rgb, size_t values);

/* One value per ray, [rows][columns]; arrays that are NULL are left out. `rays` is their length. */
typedef struct simuli_lidar_frame {
  float* range_m;   /* from the ray's own origin; 0: no return */
  float* intensity; /* [0, 1] */
  float* drop;      /* probability that the ray does not return */
  float* points_m;  /* [rays][3] in the world; of rays without a return their origins */
  size_t rays;
} simuli_lidar_frame;

simuli_status simuli_render_lidar(simuli_scene* scene,
                                  const char* name,
                                  const simuli_shot* shot,
                                  const simuli_lidar_frame* frame);

#ifdef __cplusplus
}
#endif
#endif
