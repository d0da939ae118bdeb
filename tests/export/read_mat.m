% Writes a MAT-file as Octave reads it, as text: a line for each value. Numbers have all their bits.
function read_mat(path)
  s = load(path);
  top = fieldnames(s);
  for i = 1:numel(top)
    fields = fieldnames(s.(top{i}));
    for j = 1:numel(fields)
      show([top{i} '.' fields{j}], s.(top{i}).(fields{j}));
    end
  end
end

function show(name, value)
  printf('%s\t%s\t%d\t%d', name, class(value), rows(value), columns(value));
  if iscell(value)
    for k = 1:numel(value)
      printf('\t%s', value{k});
    end
  elseif ischar(value)
    printf('\t%s', value);
  elseif isinteger(value)
    printf('\t%s', strtrim(disp(value)));
  else
    for k = 1:numel(value)
      printf('\t%s', num2hex(value(k)));
    end
  end
  printf('\n');
end
