// The depths of `scene-000000.pov`, a scene that `relievo export pov` wrote, as grey from Near (0) to Far (1):
// povray +Idepth.pov +L<folder of the scene> +FN16 +UA File_Gamma=1 Declare=Near=1 Declare=Far=9
#version 3.7;
#macro Surface_Texture(Color, Specular, Roughness)
  texture {
    pigment {
      function {
        ((x - Camera_Place.x) * Camera_Direction.x + (y - Camera_Place.y) * Camera_Direction.y
          + (z - Camera_Place.z) * Camera_Direction.z - Near) / (Far - Near)
      }
      color_map { [0 rgb 0] [1 rgb 1] }
      // Functions are of places in the object's space.
      transform { Object_Place inverse }
    }
    finish { ambient 0 diffuse 0 emission 1 }
  }
#end
#include "scene-000000.pov"
