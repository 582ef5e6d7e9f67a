// Built for another time's interfaces, of each kind that tests ask for.

extern "C" {

int prehend_generator_interface() { return 999; }
int prehend_closing_interface() { return 999; }
int prehend_sensor_interface() { return 999; }
void* prehend_create_generator() { return nullptr; }
void* prehend_create_closing() { return nullptr; }
void* prehend_create_sensor() { return nullptr; }
}
