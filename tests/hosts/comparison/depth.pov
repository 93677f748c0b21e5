// The depths of `scene-000000.pov`, a scene that `relievo scene export pov` wrote, from Near (0) to Far (1), as red
// divided by green: where POV-Ray blends the textures of vertices its weights do not always add up to 1.
// povray +Idepth.pov +L<folder of the scene> +FN16 +UA File_Gamma=1 Declare=Near=1 Declare=Far=9
#version 3.7;
#macro Surface_Texture(Color, Specular, Roughness)
  texture {
    pigment {
      gradient Camera_Direction
      color_map { [0 rgb <0, 0.5, 0>] [1 rgb <0.5, 0.5, 0>] }
      scale Far - Near
      translate Camera_Place + Near * Camera_Direction
      // The object takes its texture along to its place.
      transform { Object_Place inverse }
    }
    finish { ambient 0 diffuse 0 emission 1 }
  }
#end
#include "scene-000000.pov"
