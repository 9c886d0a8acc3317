"""The only room that touches disk: meshes in; images, GLB, features and reports out; whole or not at all."""
