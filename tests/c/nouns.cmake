# The C tests that need no graphics device and no server, one a noun.
set(nouns version error parameter context mesh surface evaluate detail tessellate collider imprint brush stroke layer document
  bake ptex picture triangles caster bezier subdivision job job_objects progressive arrival level simplify repair isosurface fluid
  foam diffuse carried state bytes stream particle_files hostile particles garbage grid decal shader tissue crowd crowd_garbage
  crowd_stream)
