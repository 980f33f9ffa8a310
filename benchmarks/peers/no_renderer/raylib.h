// As much of raylib as PufferLib's Target names, doing nothing: it is never drawn here.
#pragma once

#define PI 3.14159265358979323846f
#define KEY_ESCAPE 256
#define WHITE ((Color){255, 255, 255, 255})
#define InitWindow(width, height, title)
#define SetTargetFPS(rate)
#define LoadTexture(file) ((Texture2D){0})
#define IsKeyDown(key) 0
#define BeginDrawing()
#define EndDrawing()
#define ClearBackground(...)
#define DrawTexture(...)
#define DrawTexturePro(...)
#define UnloadTexture(texture)
#define CloseWindow()

typedef struct {
  int id;
} Texture2D;
typedef struct {
  unsigned char r, g, b, a;
} Color;
typedef struct {
  float x, y;
} Vector2;
typedef struct {
  float x, y, width, height;
} Rectangle;
