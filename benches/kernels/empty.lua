return function(face, u, v)
  return u, v, 0.5, 0.8, 0.2, 6.0
end
