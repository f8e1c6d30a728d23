// Exceptions in the same categories as the library's (core/error.hpp).
#include "bind.hpp"

#include <volccd/core/error.hpp>
#include <volccd/program/progress.hpp>

namespace volccd::python {

namespace {

// These are never freed, because they may be needed while the interpreter ends.
PyObject *error_type = nullptr, *input_error_type = nullptr, *config_error_type = nullptr;

PyObject* make_type(py::module_& module, const char* name, const char* doc, const py::tuple& bases) {
  PyObject* const type = PyErr_NewExceptionWithDoc((std::string("volccd.") + name).c_str(), doc, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  module.attr(name) = py::handle(type);
  return type;
}

/// The text of a message, which may contain a file name in another encoding.
py::object text(const std::string& message) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "replace"));
}

void raise(const InputError& error) {
  const py::object value = py::reinterpret_borrow<py::object>(input_error_type)(text(error.what()));
  value.attr("source") = text(error.source());
  value.attr("dataset") = text(error.dataset());
  value.attr("index") = error.index() == InputError::kNoIndex ? py::object(py::none()) : py::int_(error.index());
  PyErr_SetObject(input_error_type, value.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const InputError& error) {
    raise(error);
  } catch (const ConfigError& error) {
    PyErr_SetObject(config_error_type, text(error.what()).ptr());
  } catch (const Interrupted& error) {
    PyErr_SetObject(PyExc_KeyboardInterrupt, text(error.what()).ptr());
  } catch (const Error& error) {
    PyErr_SetObject(error_type, text(error.what()).ptr());
  }
}

}  // namespace

void bind_errors(py::module_& module) {
  const py::handle runtime_error(PyExc_RuntimeError), value_error(PyExc_ValueError);
  error_type =
      make_type(module, "Error", "Base of everything that volccd raises on purpose.", py::make_tuple(runtime_error));
  input_error_type = make_type(module, "InputError",
                               "Bad input data. `source` is the file, or a word such as 'mesh' for arrays; `dataset` "
                               "names the array in it and may\n"
                               "be empty; `index` is the row, or None.",
                               py::make_tuple(py::handle(error_type), value_error));
  const py::handle input_error(input_error_type);
  input_error.attr("source") = "";
  input_error.attr("dataset") = "";
  input_error.attr("index") = py::none();
  config_error_type =
      make_type(module, "ConfigError",
                "A stage, option or combination that does not exist, or whose completeness argument does\n"
                "not hold.",
                py::make_tuple(py::handle(error_type), value_error));
  py::register_exception_translator(&translate);
}

}  // namespace volccd::python
