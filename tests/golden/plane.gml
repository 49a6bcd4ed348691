% A checkered floor up to the horizon.
{ /v /u /face u floor v floor addi 2 modi 0 eqi { 1.0 1.0 1.0 point } { 0.2 0.3 0.4 point } if 1.0 0.0 1.0 }
plane 0.0 -0.7 0.0 translate /scene
1.0 1.0 1.0 point [] scene 0 90.0 64 48 "plane.ppm" render
