/* render SCENE: one frame of each sensor at the start of the recorded path, all on their way at once. */
#include <simuli/simuli.h>
#include <stdio.h>
#include <stdlib.h>

static int fail(const char* what) {
  fprintf(stderr, "%s: %s\n", what, simuli_error());
  return 1;
}

static int print(const simuli_sensor* sensor, const simuli_frame* frame) {
  const size_t rays = sensor->rows * sensor->columns;
  const size_t count = sensor->is_camera ? 3 * rays : rays;
  float* values = malloc(count * sizeof(float));
  double sum = 0.0;
  const simuli_status status =
      simuli_frame_values(frame, sensor->is_camera ? SIMULI_RGB : SIMULI_RANGE, values, count);
  for (size_t i = 0; status == SIMULI_OK && i < rays; ++i) sum += values[sensor->is_camera ? 3 * i : i];
  free(values);
  if (status != SIMULI_OK) return fail(sensor->name);
  printf("%s: mean %s %.3f\n", sensor->name, sensor->is_camera ? "red" : "range", sum / (double)rays);
  return 0;
}

int main(int argc, char** argv) {
  simuli_device* device = NULL;
  simuli_scene* scene = NULL;
  simuli_frame* frames[16] = {NULL};
  double start_s = 0.0, end_s = 0.0;
  int failed = 0;
  if (argc != 2) return fprintf(stderr, "usage: render SCENE\n"), 2;
  if (simuli_device_open(NULL, &device) != SIMULI_OK) return fail("device");
  printf("simuli %s on %s\n", simuli_version(), simuli_device_name(device));
  if (simuli_scene_open(device, argv[1], &scene) != SIMULI_OK) return fail("scene");
  if (simuli_scene_span(scene, &start_s, &end_s) != SIMULI_OK) return fail("span");
  const size_t count = simuli_scene_sensor_count(scene) < 16 ? simuli_scene_sensor_count(scene) : 16;
  for (size_t i = 0; i < count; ++i) {
    simuli_sensor sensor;
    simuli_shot shot;
    if (simuli_scene_sensor(scene, i, &sensor) != SIMULI_OK) return fail("sensor");
    if (simuli_scene_shot(scene, sensor.name, start_s, start_s + sensor.duration_s, &shot) != SIMULI_OK) {
      return fail("shot");
    }
    if (simuli_render(scene, sensor.name, &shot, NULL, &frames[i]) != SIMULI_OK) return fail(sensor.name);
  }
  for (size_t i = 0; i < count; ++i) {
    simuli_sensor sensor;
    simuli_scene_sensor(scene, i, &sensor);
    failed |= print(&sensor, frames[i]);
    simuli_frame_close(frames[i]);
  }
  simuli_scene_close(scene);
  simuli_device_close(device);
  return failed;
}
